/** What workers handed in, one by one: accept, reject, correct. `/review?collection=NAME`. */
import type { Change, Collection, Work } from '../collections.ts';
import { action, field, labelled, loggedIn, onlyFor, type Who } from '../forms.ts';
import { api, byId, dateTime, json, make, problems, run, table } from '../page.ts';
import { viewpointIndex } from '../scan.ts';
import { MiniMap, Player, Viewer } from '../viewer/enfilade-viewer.ts';

type State = Work['state'];
const perPage = 50;
const states: readonly (readonly [State | 'all', string])[] = [
  ['submitted', 'Waiting for review'], ['accepted', 'Accepted'], ['rejected', 'Rejected'], ['all', 'All'],
];
const stateTexts: Record<State, string> = { submitted: 'waiting for review', accepted: 'accepted', rejected: 'rejected' };
const flagTexts: Record<string, string> = {
  short: 'very short', pasted: 'partly pasted', 'goal-not-seen': 'never looked around at the goal',
};

/** The viewer of a building, kept while the next work is in the same one. */
class Stage {
  private readonly view: HTMLElement;
  private readonly mapBox: HTMLElement;
  private viewer: Viewer | undefined;
  private map: MiniMap | undefined;
  private player: Player | undefined;

  constructor(view: HTMLElement, mapBox: HTMLElement) {
    this.view = view;
    this.mapBox = mapBox;
  }

  /** Shows a work's path or walk from its start. Returns the fly-through. */
  async show(work: Work): Promise<HTMLElement> {
    this.player?.dispose();
    const ids = work.path ?? (work.steps ?? []).map(({ viewpoint }) => viewpoint);
    if (this.viewer?.scan.scan !== work.scan) await this.open(work.scan);
    const viewer = this.viewer!;
    const path = ids.map((id) => viewpointIndex(viewer.scan, id))
      .filter((v, k, all) => v !== all[k - 1]);
    await viewer.jump({ viewpoint: path[0]!, heading: work.heading, elevation: 0 });
    viewer.setPath(path);
    this.map!.setPath(work.path ? path : [], work.path ? [] : path);
    this.player = new Player(viewer, path);
    return this.player.element;
  }

  private async open(scan: string): Promise<void> {
    this.map?.dispose();
    this.viewer?.dispose();
    this.viewer = await Viewer.open(this.view, { scan });
    this.map = new MiniMap(this.viewer);
    this.mapBox.replaceChildren(this.map.element);
  }
}

class Reviewer {
  private readonly collection: Collection;
  private readonly stage: Stage;
  private readonly state = make('select', {}, ...states.map(([value, text]) => new Option(text, value)));
  private readonly place = make('p', { role: 'status' });
  private readonly work = make('div');
  private readonly said = make('div');
  private list: Work[] = [];
  private matching = 0;
  private at = 0;

  constructor(collection: Collection, stage: Stage, panel: HTMLElement) {
    this.collection = collection;
    this.stage = stage;
    const turn = (text: string, label: string, by: number) =>
      action(text, this.said, () => this.go(this.at + by), { 'aria-label': label });
    panel.append(make('label', { class: 'row' }, 'Show', this.state),
      make('p', { class: 'buttons' }, turn('◀', 'The one before', -1), turn('▶', 'The next one', 1), this.place),
      this.said, this.work);
    this.state.addEventListener('change', () => {
      this.load().catch((error: unknown) => this.said.replaceChildren(problems(error)));
    });
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
    this.place.textContent = one ? `${this.at + 1} of ${this.matching}` : 'Nothing here.';
    if (!one) return this.work.replaceChildren();
    if (at > last) this.place.textContent += ': this was the last.';
    await this.show(await api.call<Work>(`tasks/${one.task}`));
  }

  private async show(work: Work): Promise<void> {
    const player = await this.stage.show(work);
    const heading = make('h2', { tabindex: '-1' }, `Task ${work.task}: ${stateTexts[work.state]}`);
    const focused = this.work.contains(document.activeElement); // on what is about to go
    this.list[this.at] = work;
    this.work.replaceChildren(
      heading, this.facts(work),
      work.kind === 'write' ? this.editor(work) : make('p', { class: 'instruction' }, work.instruction ?? ''),
      player, this.verdict(work), ...this.history(work.history ?? []));
    if (focused) heading.focus();
  }

  private facts(work: Work): HTMLElement {
    const facts = [`Worker ${work.worker}`, `path ${work.path_id} of ${work.split}`, dateTime(work.submitted)];
    if (work.seconds !== undefined) facts.push(`${Math.round(work.seconds)} s`);
    if (work.bonus !== undefined) facts.push(work.bonus ? 'stopped within 3 m of the goal' : 'stopped 3 m or more from the goal');
    const odd = (work.flags ?? []).map((flag) => flagTexts[flag] ?? flag);
    return make('p', { class: 'note' }, `${facts.join(', ')}.`, ...(odd.length > 0 ? [make('strong', {}, ` Passed over: ${odd.join(', ')}.`)] : []));
  }

  private editor(work: Work): HTMLElement {
    const text = make('textarea', { rows: '5', maxlength: '2000' });
    text.value = work.instruction ?? '';
    const [box] = labelled('instruction', 'The directions', text);
    const save = action('Save the correction', this.said, async () => {
      await this.show(await api.call<Work>(`tasks/${work.task}/instruction`, json({ instruction: text.value.trim() }, 'PUT')));
    });
    save.hidden = true;
    text.addEventListener('input', () => { save.hidden = text.value.trim() === (work.instruction ?? ''); });
    box.append(save);
    return box;
  }

  private verdict(work: Work): HTMLElement {
    const [why, reason] = field('reason', 'Why, if you reject it', { maxlength: '500' });
    reason.value = work.reason ?? '';
    const send = async (verdict: State): Promise<void> => {
      const body = verdict === 'rejected' ? { verdict, reason: reason.value.trim() } : { verdict };
      this.list[this.at] = await api.call<Work>(`tasks/${work.task}/review`, json(body, 'PUT'));
      await this.go(this.at + 1);
    };
    const reject = action('Reject', this.said, async () => {
      if (reason.value.trim() === '') {
        this.said.replaceChildren(make('p', { class: 'problem', role: 'alert' }, 'Say why.'));
        return reason.focus();
      }
      await send('rejected');
    });
    return make('div', {}, why, make('p', { class: 'buttons' }, action('Accept', this.said, () => send('accepted'), { class: 'main' }), reject));
  }

  private history(list: readonly Change[]): HTMLElement[] {
    if (list.length === 0) return [];
    const rows = list.map(({ when, who, what, before, reason }) =>
      [dateTime(when), who, what, before ?? reason ?? '']);
    return [make('h2', {}, 'What was done with it'), table(['When', 'Who', 'What', 'Why, or what it was'], rows)];
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
  await new Reviewer(collection, new Stage(view, map), panel).load();
});
