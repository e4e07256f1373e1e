/** Submitted work one by one: what was written or walked, and the verdict, first; then its path and its history. */
import { addressOf, reviewPage } from '../collecting/addresses.ts';
import type { Change, Collection, Turn, Work } from '../collecting/collections.ts';
import { action, field, labelled } from '../elements/forms.ts';
import { counted, dateTime, make, problems, table } from '../elements/page.ts';
import { api, json } from '../server/api.ts';
import { Filters } from './filters.ts';
import { Stage } from './stage.ts';
import { duration, hintsOf, isWritten, outcomeOf, type State, stateTexts } from './words.ts';

const perPage = 50;

/** What two people said, and how far was walked in between. */
function dialogueList(turns: readonly Turn[]): HTMLElement {
  const list = make('ol', { class: 'turns', 'aria-label': 'What was said', tabindex: '0' });
  let steps = 0;
  let at = turns[0]?.viewpoint;
  for (const { role, text, viewpoint } of turns) {
    if (viewpoint !== at) steps += 1;
    at = viewpoint;
    if (text === undefined) continue;
    const who = `${role === 'navigator' ? 'Navigator' : 'Oracle'}, after ${counted(steps, 'step')}: `;
    list.append(make('li', { class: role }, make('strong', {}, who), text));
  }
  return list;
}

function historyOf(list: readonly Change[]): HTMLElement[] {
  if (list.length === 0) return [];
  const rows = list.map(({ when, who, what, before, reason }) =>
    [dateTime(when), who, what, before ?? reason ?? '']);
  return [make('h2', {}, 'History'), table(['When', 'Who', 'What', 'Reason, or the text before'], rows)];
}

function factsOf(work: Work): HTMLElement {
  const facts = [`Worker ${work.worker}`, `path ${work.path_id} of ${work.split}`, dateTime(work.submitted)];
  const page = `the page's ${duration(work.page_seconds)}`;
  facts.push(work.seconds === undefined ? page : `${duration(work.seconds)} by the server (${page})`);
  if (work.role) facts.push(`${work.role} of dialogue ${work.dialogue}`);
  if (work.spoken !== undefined) facts.push(work.spoken ? 'spoken, at least in part' : 'typed');
  if (work.verified && work.verified.walked > 0) facts.push(`${work.verified.found} of ${work.verified.walked} who looked for it found it`);
  return make('p', { class: 'note' }, `${facts.join(', ')}.`);
}

class Queue {
  private readonly collection: Collection;
  private readonly stage: Stage;
  private readonly filters: Filters;
  private readonly keys = make('input', { type: 'checkbox' });
  private readonly place = make('p', { role: 'status' });
  private readonly said = make('div');
  /** The work and its verdict. */
  private readonly judged = make('div');
  private readonly more = make('div');
  /** All below the verdict: there once its height is known, so that nothing moves. */
  private readonly rest = make('div', { hidden: '' });
  /** Texts that were changed and not stored yet, by task: they survive a look at another one. */
  private readonly edits = new Map<number, string>();
  private readonly reasons = new Map<number, string>();
  private accept: HTMLButtonElement | undefined;
  private reject: HTMLButtonElement | undefined;
  private list: Work[] = [];
  private matching = 0;
  private at = 0;
  /** Counts what was asked for: only the last is shown. */
  private asked = 0;

  constructor(collection: Collection, stage: Stage, panel: HTMLElement, map: HTMLElement) {
    this.collection = collection;
    this.stage = stage;
    this.filters = new Filters(collection.collection, 'submitted', () => this.reload());
    const turn = (text: string, label: string, by: number) =>
      action(text, this.said, () => this.go(this.at + by), { 'aria-label': label });
    panel.append(this.filters.element,
      make('div', { class: 'decision' },
        make('p', { class: 'buttons' }, turn('◀ Previous', 'Previous', -1), turn('Next ▶', 'Next', 1), this.place), this.judged, this.said),
      this.rest);
    this.rest.append(map, this.more,
      make('p', { class: 'note keys' }, make('label', { class: 'row' }, this.keys, 'Keys'),
        ': A accepts, R goes to the reason and Enter there rejects, N and P go to the next and the previous one, E edits, Esc leaves a field.'));
    this.keys.checked = true;
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('beforeunload', (event) => { if (this.edits.size > 0) event.preventDefault(); });
  }

  async open(): Promise<void> {
    await this.filters.open();
    await this.load();
  }

  private reload(): void {
    this.load().catch((error: unknown) => this.said.replaceChildren(problems(error)));
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
      n: () => this.turn(1),
      p: () => this.turn(-1),
    };
    const act = acts[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  private turn(by: number): void {
    this.go(this.at + by).catch((error: unknown) => this.said.replaceChildren(problems(error)));
  }

  /** The queue anew, from its first. */
  private async load(): Promise<void> {
    const asked = ++this.asked;
    this.list = [];
    await this.fetch();
    if (asked === this.asked) await this.go(0);
  }

  private async fetch(): Promise<void> {
    const { list } = this;
    const after = list.at(-1)?.task ?? 0;
    const query = new URLSearchParams({ ...this.filters.query(), after: String(after), limit: String(perPage) });
    const found = await api.call<{ matching: number; work: Work[] }>(`${addressOf(this.collection.collection)}/work?${query}`);
    if (list !== this.list || (list.at(-1)?.task ?? 0) !== after) return; // another list, or these are there already
    if (list.length === 0) this.matching = found.matching; // later ones change it as we review
    list.push(...found.work);
  }

  private async go(at: number): Promise<void> {
    const asked = ++this.asked;
    if (at >= this.list.length && this.list.length < this.matching) await this.fetch();
    if (asked !== this.asked) return; // gone on meanwhile
    const last = this.list.length - 1;
    this.at = Math.min(Math.max(at, 0), Math.max(last, 0));
    const one = this.list[this.at];
    [this.accept, this.reject] = [undefined, undefined]; // a key that is pressed too fast judges nothing
    if (!one) return this.showEnd();
    const work = await api.call<Work>(`tasks/${one.task}`);
    if (asked === this.asked) await this.show(work);
    if (asked === this.asked) this.place.textContent = `${this.at + 1} of ${this.matching}${at > last ? ': this was the last.' : ''}`;
  }

  /** After a verdict: to the next, and at the end to what was passed over. */
  private async goOn(): Promise<void> {
    const isLast = this.at + 1 >= this.list.length && this.list.length >= this.matching;
    if (isLast && this.filters.isQueue) return this.load();
    await this.go(this.at + 1);
  }

  /** There is nothing to show, and why. */
  private showEnd(): void {
    const { accepted = 0, rejected = 0, submitted = 0 } = this.collection.progress ?? {};
    const begun = accepted + rejected + submitted > 0;
    const link = (text: string, href: string) => make('a', { href, class: 'button' }, text);
    const { collection: name } = this.collection;
    const focused = this.judged.contains(document.activeElement);
    const [title, text] = !begun ? ['Nothing is submitted yet', 'What workers submit will wait here.']
      : !this.filters.isQueue ? ['Nothing here', 'No work is in this state, of this worker and this path.']
        : ['All reviewed', `No work of this ${this.filters.isWholeQueue ? 'collection' : 'worker or this path'} waits for review.`];
    this.place.textContent = '';
    this.rest.hidden = true;
    this.judged.replaceChildren(make('h2', { tabindex: '-1' }, title), make('p', {}, text), make('p', { class: 'buttons' },
      ...(begun ? [link('All work, as a table', reviewPage(name, { view: 'table' })),
        link('Agreement and checks', reviewPage(name, { view: 'agreement' }))] : []),
      link('To the collections and their files', '/organise')));
    if (focused) this.judged.querySelector('h2')!.focus();
  }

  private async show(work: Work): Promise<void> {
    const { asked } = this;
    const tools = await this.stage.show(work);
    if (asked !== this.asked) return; // gone on meanwhile
    const heading = make('h2', { tabindex: '-1' }, `Task ${work.task}: ${stateTexts[work.state]}`);
    const focused = this.judged.contains(document.activeElement); // on what is about to go
    this.list[this.at] = work;
    const hints = hintsOf(work);
    const outcome = outcomeOf(work);
    this.judged.replaceChildren(heading, ...this.content(work),
      ...(outcome ? [make('p', {}, 'It ', make('strong', {}, outcome), '.')] : []),
      ...(hints.length > 0 ? [make('p', {}, make('strong', {}, `Hints skipped: ${hints.join(', ')}.`))] : []), this.verdict(work));
    this.rest.hidden = false;
    this.more.replaceChildren(...tools, factsOf(work), ...this.words(work), ...historyOf(work.history ?? []));
    if (focused) heading.focus();
  }

  /** What was submitted, as its kind asks for. */
  private content(work: Work): HTMLElement[] {
    const about = work.kind === 'dialogue' ? 'Looked for: ' : 'The object, in its orange frame: ';
    const object = work.object ? [make('p', {}, about, make('strong', {}, work.object.name))] : [];
    if (isWritten(work.kind)) return [...object, this.editor(work)];
    if (work.turns) return [...object, dialogueList(work.turns)];
    return [make('p', { class: 'instruction', tabindex: '0' }, work.instruction ?? ''), ...object];
  }

  private words({ words }: Work): HTMLElement[] {
    if (!words) return [];
    const rows = words.map(({ word, start, end }) => [word, `${start.toFixed(1)} s`, `${end.toFixed(1)} s`]);
    return [make('details', {}, make('summary', {}, 'Words and their times'), table(['Word', 'From', 'To'], rows))];
  }

  private editor(work: Work): HTMLElement {
    const text = make('textarea', { rows: '5', maxlength: '2000' });
    const stored = work.instruction ?? '';
    text.value = this.edits.get(work.task) ?? stored;
    const [box] = labelled('instruction', 'The directions', text);
    const { asked } = this;
    const save = action('Save the correction', this.said, async () => {
      const saved = await api.call<Work>(`tasks/${work.task}/instruction`, json({ instruction: text.value.trim() }, 'PUT'));
      this.edits.delete(work.task);
      if (asked === this.asked) await this.show(saved);
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
    const { list, at, asked } = this;
    const send = async (verdict: State): Promise<void> => {
      const corrected = this.edits.get(work.task)?.trim();
      const body = verdict === 'rejected' ? { verdict, reason: reason.value.trim() }
        : { verdict, ...(corrected && { instruction: corrected }) }; // what stands there is what is accepted
      list[at] = await api.call<Work>(`tasks/${work.task}/review`, json(body, 'PUT'));
      this.edits.delete(work.task);
      this.reasons.delete(work.task);
      if (asked === this.asked) await this.goOn(); // unless one went on meanwhile
    };
    this.reject = action('Reject', this.said, async () => {
      if (reason.value.trim() === '') {
        this.said.replaceChildren(make('p', { class: 'problem', role: 'alert' }, 'A rejection needs a reason.'));
        return reason.focus();
      }
      await send('rejected');
    });
    this.accept = action('Accept', this.said, () => send('accepted'), { class: 'main' });
    return make('div', {}, make('p', { class: 'buttons' }, this.accept, this.reject), why);
  }
}

/** @param head stands above it */
export async function showQueue(main: HTMLElement, collection: Collection, head: readonly HTMLElement[]): Promise<void> {
  const [view, map] = [make('div', { class: 'view' }), make('div', { class: 'map' })];
  const panel = make('div', { class: 'panel' }, ...head);
  main.append(view, make('aside', { class: 'side work', 'aria-label': 'Work' }, panel));
  await new Queue(collection, new Stage(view, map), panel, map).open();
}
