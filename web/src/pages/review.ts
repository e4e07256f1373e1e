/**
 * What workers submitted, one by one: accept, reject, correct. `/review?collection=NAME`, with `state`, `worker` and `path`
 * for some of it only, which Back brings back.
 */
import type { Change, Collection, Kind, Turn, Work, WorkSummary } from '../collecting/collections.ts';
import { action, field, labelled, loggedIn, onlyFor, type Who } from '../elements/forms.ts';
import { byId, dateTime, make, problems, run, table } from '../elements/page.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { api, json } from '../server/api.ts';
import { MiniMap, Outlines, Player, Viewer } from '../viewer/enfilade-viewer.ts';
import { outlinesIn } from '../work/targets.ts';

type State = Work['state'];
const perPage = 50;
const states: readonly (readonly [State | 'all', string])[] = [
  ['submitted', 'Waiting for review'], ['accepted', 'Accepted'], ['rejected', 'Rejected'], ['all', 'All'],
];
const stateTexts: Record<State, string> = { submitted: 'waiting for review', accepted: 'accepted', rejected: 'rejected' };
const flagTexts: Record<string, string> = {
  short: 'very short', pasted: 'partly pasted', 'goal-not-seen': 'never looked around at the goal',
  'time-mismatch': 'the page claims more time than the server saw',
};

const stoppedTexts = ['stopped 3 m or more from the goal', 'stopped within 3 m of the goal'] as const;
const foundTexts = ['pointed at something else', 'pointed at the object'] as const;
const isWritten = (kind: Kind): boolean => kind === 'write' || kind === 'describe';

/** What two people said, and how far was walked in between. */
function dialogueList(turns: readonly Turn[]): HTMLElement {
  const list = make('ol', { class: 'turns', 'aria-label': 'What was said', tabindex: '0' });
  let steps = 0;
  let at = turns[0]?.viewpoint;
  for (const { role, text, viewpoint } of turns) {
    if (viewpoint !== at) steps += 1;
    at = viewpoint;
    if (text !== undefined) list.append(make('li', { class: role }, make('strong', {}, `${role === 'navigator' ? 'Navigator' : 'Oracle'}, after ${steps} step${steps === 1 ? '' : 's'}: `), text));
  }
  return list;
}

/** "4 min 12 s" */
function duration(seconds: number): string {
  const [minutes, rest] = [Math.floor(seconds / 60), Math.round(seconds % 60)];
  return minutes > 0 ? `${minutes} min ${rest} s` : `${rest} s`;
}

/** The viewer of a building, kept while the next work is in the same one. */
class Stage {
  private readonly view: HTMLElement;
  private readonly mapBox: HTMLElement;
  private viewer: Viewer | undefined;
  private map: MiniMap | undefined;
  private player: Player | undefined;
  private outlines: Outlines | undefined;

  constructor(view: HTMLElement, mapBox: HTMLElement) {
    this.view = view;
    this.mapBox = mapBox;
  }

  /** Shows a work's path or walk from its start. Returns the fly-through. */
  async show(work: Work): Promise<HTMLElement> {
    this.player?.dispose();
    this.outlines?.dispose();
    const ids = work.path ?? (work.steps ?? work.turns ?? []).map(({ viewpoint }) => viewpoint);
    if (this.viewer?.scan.scan !== work.scan) await this.open(work.scan);
    const viewer = this.viewer!;
    const path = ids.map((id) => viewpointIndex(viewer.scan, id))
      .filter((v, k, all) => v !== all[k - 1]);
    await viewer.jump({ viewpoint: path[0]!, heading: work.heading, elevation: 0 });
    viewer.setPath(path);
    this.map!.setPath(work.path ? path : [], work.path ? [] : path);
    this.player = new Player(viewer, path);
    this.outlines = work.object && new Outlines(viewer, outlinesIn(viewer.scan, work.object));
    this.outlines?.setPoint(work.point, path.at(-1));
    return this.player.element;
  }

  private async open(scan: string): Promise<void> {
    this.map?.dispose();
    this.viewer?.dispose();
    this.viewer = await Viewer.open(this.view, { scan });
    this.map = new MiniMap(this.viewer);
    void this.map.loadPlan(api, true);
    this.mapBox.replaceChildren(this.map.element);
  }
}

class Reviewer {
  private readonly collection: Collection;
  private readonly stage: Stage;
  private readonly state = make('select', {}, ...states.map(([value, text]) => new Option(text, value)));
  private readonly worker = make('select', {});
  private readonly path = make('select', {});
  private readonly keys = make('input', { type: 'checkbox' });
  private readonly place = make('p', { role: 'status' });
  private readonly work = make('div');
  private readonly said = make('div');
  /** Texts that were changed and not stored yet, by task: they survive a look at another one. */
  private readonly edits = new Map<number, string>();
  private readonly reasons = new Map<number, string>();
  private accept: HTMLButtonElement | undefined;
  private reject: HTMLButtonElement | undefined;
  private list: Work[] = [];
  private matching = 0;
  private at = 0;

  constructor(collection: Collection, stage: Stage, panel: HTMLElement) {
    this.collection = collection;
    this.stage = stage;
    const turn = (text: string, label: string, by: number) =>
      action(text, this.said, () => this.go(this.at + by), { 'aria-label': label });
    panel.append(
      make('div', { class: 'filters' }, make('label', { class: 'row' }, 'Show', this.state),
        make('label', { class: 'row' }, 'Worker', this.worker), make('label', { class: 'row' }, 'Path', this.path)),
      make('p', { class: 'buttons' }, turn('◀ Previous', 'Previous', -1), turn('Next ▶', 'Next', 1), this.place),
      this.said, this.work,
      make('p', { class: 'note keys' }, make('label', { class: 'row' }, this.keys, 'Keys'),
        ': A accepts, R goes to the reason and Enter there rejects, N and P go to the next and the previous one, E edits, Esc leaves a field.'));
    this.keys.checked = true;
    for (const [name, select] of this.filters()) {
      select.addEventListener('change', () => {
        const query = new URLSearchParams(location.search);
        if (select.value === '' || select.value === 'submitted') query.delete(name);
        else query.set(name, select.value);
        history.pushState(null, '', `?${query}`);
        this.reload();
      });
    }
    addEventListener('popstate', () => this.reload());
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('beforeunload', (event) => { if (this.edits.size > 0) event.preventDefault(); });
  }

  /** What the page's address names each of them. */
  private filters(): [string, HTMLSelectElement][] {
    return [['state', this.state], ['worker', this.worker], ['path', this.path]];
  }

  private reload(): void {
    this.followAddress().catch((error: unknown) => this.said.replaceChildren(problems(error)));
  }

  /** Fills the lists of workers and paths, and shows what the page's address names. */
  async open(): Promise<void> {
    const [workers, paths] = await Promise.all([this.summaries('workers'), this.summaries('paths')]);
    const all = new Option('all', '');
    this.worker.replaceChildren(all, ...workers.map((one) => new Option(this.summary(`${one.worker}`, one), String(one.worker))));
    this.path.replaceChildren(all.cloneNode(true), ...paths.map((one) => new Option(this.summary(`${one.path_id}`, one), String(one.path_id))));
    await this.followAddress();
  }

  /** What the page's address names. */
  private followAddress(): Promise<void> {
    const query = new URLSearchParams(location.search);
    this.state.value = query.get('state') ?? 'submitted';
    this.worker.value = query.get('worker') ?? '';
    this.path.value = query.get('path') ?? '';
    return this.load();
  }

  /** All of them: the server sends a limited number per request. */
  private async summaries(by: 'workers' | 'paths'): Promise<WorkSummary[]> {
    const most = 1000;
    const all: WorkSummary[] = [];
    for (let after = -1; ;) {
      const page = (await api.call<Partial<Record<typeof by, WorkSummary[]>>>(
        `collections/${encodeURIComponent(this.collection.collection)}/work/${by}?limit=${most}&after=${after}`))[by] ?? [];
      all.push(...page);
      if (page.length < most) return all;
      after = page.at(-1)![by === 'workers' ? 'worker' : 'path_id']!;
    }
  }

  private summary(name: string, { submitted, accepted, rejected, flagged, mean_seconds, checks = 0, checks_failed = 0 }: WorkSummary): string {
    const facts = [`${submitted + accepted + rejected} done`, `${duration(mean_seconds)} each`];
    if (rejected > 0) facts.push(`${rejected} rejected`);
    if (flagged > 0) facts.push(`${flagged} with hints`);
    if (checks > 0) facts.push(`${checks_failed} of ${checks} checks failed`);
    return `${name}: ${facts.join(', ')}`;
  }

  /** Keys work wherever nothing is typed; those who speak to their computer can switch them off. */
  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    const typing = target.matches('input:not([type=checkbox]), textarea, select');
    if (!this.keys.checked || event.ctrlKey || event.metaKey || event.altKey) return;
    if (typing) {
      if (event.key === 'Escape') target.blur();
      if (event.key !== 'Enter' || target.id !== 'reason') return;
      event.preventDefault();
      this.reject?.click();
      return;
    }
    const acts: Record<string, () => void> = {
      a: () => this.accept?.click(),
      r: () => document.getElementById('reason')?.focus(),
      e: () => document.getElementById('instruction')?.focus(),
      n: () => void this.go(this.at + 1),
      p: () => void this.go(this.at - 1),
    };
    const act = acts[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  /** The queue anew, from its first. */
  async load(): Promise<void> {
    this.list = [];
    await this.more();
    await this.go(0);
  }

  private async more(): Promise<void> {
    const query = new URLSearchParams({
      state: this.state.value, after: String(this.list.at(-1)?.task ?? 0), limit: String(perPage),
    });
    if (this.worker.value) query.set('worker', this.worker.value);
    if (this.path.value) query.set('path_id', this.path.value);
    const name = encodeURIComponent(this.collection.collection);
    const found = await api.call<{ matching: number; work: Work[] }>(`collections/${name}/work?${query}`);
    if (this.list.length === 0) this.matching = found.matching; // later ones change it as we review
    this.list.push(...found.work);
  }

  private async go(at: number): Promise<void> {
    if (at >= this.list.length && this.list.length < this.matching) await this.more();
    const last = this.list.length - 1;
    this.at = Math.min(Math.max(at, 0), Math.max(last, 0));
    const one = this.list[this.at];
    [this.accept, this.reject] = [undefined, undefined]; // a key that is pressed too fast judges nothing
    if (!one) {
      this.place.textContent = 'Nothing here.';
      return this.work.replaceChildren();
    }
    await this.show(await api.call<Work>(`tasks/${one.task}`));
    this.place.textContent = `${this.at + 1} of ${this.matching}${at > last ? ': this was the last.' : ''}`;
  }

  private async show(work: Work): Promise<void> {
    const player = await this.stage.show(work);
    const heading = make('h2', { tabindex: '-1' }, `Task ${work.task}: ${stateTexts[work.state]}`);
    const focused = this.work.contains(document.activeElement); // on what is about to go
    this.list[this.at] = work;
    this.work.replaceChildren(
      heading, this.facts(work),
      ...this.content(work),
      player, this.verdict(work), ...this.history(work.history ?? []));
    if (focused) heading.focus();
  }

  /** What was submitted, as its kind asks for. */
  private content(work: Work): HTMLElement[] {
    const object = work.object ? [make('p', {}, work.kind === 'dialogue' ? 'Looked for: ' : 'The object, in its orange frame: ', make('strong', {}, work.object.name))] : [];
    const text = make('p', { class: 'instruction' }, work.instruction ?? '');
    if (isWritten(work.kind)) return [...object, this.editor(work)];
    if (work.turns) return [...object, dialogueList(work.turns)];
    if (!work.words) return [text, ...object];
    const rows = work.words.map(({ word, start, end }) => [word, `${start.toFixed(1)} s`, `${end.toFixed(1)} s`]);
    return [text, make('details', {}, make('summary', {}, 'Words and their times'), table(['Word', 'From', 'To'], rows))];
  }

  private facts(work: Work): HTMLElement {
    const facts = [`Worker ${work.worker}`, `path ${work.path_id} of ${work.split}`, dateTime(work.submitted)];
    const page = `the page's ${duration(work.page_seconds)}`;
    facts.push(work.seconds === undefined ? page : `${duration(work.seconds)} by the server (${page})`);
    if (work.bonus !== undefined) facts.push((work.kind === 'find' ? foundTexts : stoppedTexts)[Number(work.bonus) as 0 | 1]);
    if (work.role) facts.push(`${work.role} of dialogue ${work.dialogue}`);
    if (work.spoken !== undefined) facts.push(work.spoken ? 'spoken, at least in part' : 'typed');
    if (work.verified && work.verified.walked > 0) facts.push(`${work.verified.found} of ${work.verified.walked} who looked for it found it`);
    const odd = (work.flags ?? []).map((flag) => flagTexts[flag] ?? flag);
    return make('p', { class: 'note' }, `${facts.join(', ')}.`, ...(odd.length > 0 ? [make('strong', {}, ` Hints skipped: ${odd.join(', ')}.`)] : []));
  }

  private editor(work: Work): HTMLElement {
    const text = make('textarea', { rows: '5', maxlength: '2000' });
    const stored = work.instruction ?? '';
    text.value = this.edits.get(work.task) ?? stored;
    const [box] = labelled('instruction', 'The directions', text);
    const save = action('Save the correction', this.said, async () => {
      const saved = await api.call<Work>(`tasks/${work.task}/instruction`, json({ instruction: text.value.trim() }, 'PUT'));
      this.edits.delete(work.task);
      await this.show(saved);
    });
    const changed = () => {
      const same = text.value.trim() === stored;
      save.hidden = same;
      if (same) this.edits.delete(work.task);
      else this.edits.set(work.task, text.value);
    };
    changed();
    text.addEventListener('input', changed);
    box.append(save);
    return box;
  }

  private verdict(work: Work): HTMLElement {
    const [why, reason] = field('reason', 'Why, if you reject it (the worker reads this)', { maxlength: '500' });
    reason.value = this.reasons.get(work.task) ?? work.reason ?? '';
    reason.addEventListener('input', () => this.reasons.set(work.task, reason.value));
    const send = async (verdict: State): Promise<void> => {
      const corrected = this.edits.get(work.task)?.trim();
      const body = verdict === 'rejected' ? { verdict, reason: reason.value.trim() }
        : { verdict, ...(corrected && { instruction: corrected }) }; // what stands there is what is accepted
      this.list[this.at] = await api.call<Work>(`tasks/${work.task}/review`, json(body, 'PUT'));
      this.edits.delete(work.task);
      this.reasons.delete(work.task);
      await this.go(this.at + 1);
    };
    this.reject = action('Reject', this.said, async () => {
      if (reason.value.trim() === '') {
        this.said.replaceChildren(make('p', { class: 'problem', role: 'alert' }, 'A rejection needs a reason.'));
        return reason.focus();
      }
      await send('rejected');
    });
    this.accept = action('Accept', this.said, () => send('accepted'), { class: 'main' });
    return make('div', {}, why, make('p', { class: 'buttons' }, this.accept, this.reject));
  }

  private history(list: readonly Change[]): HTMLElement[] {
    if (list.length === 0) return [];
    const rows = list.map(({ when, who, what, before, reason }) =>
      [dateTime(when), who, what, before ?? reason ?? '']);
    return [make('h2', {}, 'History'), table(['When', 'Who', 'What', 'Reason, or the text before'], rows)];
  }
}

async function chooser(who: Who): Promise<void> {
  const { collections } = await api.call<{ collections: Collection[] }>('collections');
  const main = byId('main');
  main.classList.remove('wide');
  main.append(make('h1', {}, 'Review'), loggedIn(who), collections.length === 0 ? make('p', {}, 'There is no collection yet.')
    : make('ul', {}, ...collections.map(({ collection, title, progress }) => make('li', {},
      make('a', { href: `/review?${new URLSearchParams({ collection })}` }, title), `: ${progress?.submitted ?? 0} to review`))));
}

run(async () => {
  const who = await onlyFor(['organiser', 'reviewer'], 'Review');
  if (!who) return;
  const name = new URLSearchParams(location.search).get('collection');
  if (!name) return chooser(who);
  const collection = await api.call<Collection>(`collections/${encodeURIComponent(name)}`);
  document.title = `Review ${collection.title} · Enfilade`;
  const [view, side, map] = [make('div', { class: 'view' }), make('aside', { class: 'side work' }), make('div', { class: 'map' })];
  const panel = make('div', { class: 'panel' }, make('h1', {}, `Review: ${collection.title}`));
  side.append(map, panel);
  byId('main').append(view, side);
  await new Reviewer(collection, new Stage(view, map), panel).open();
});
