/** All submitted work as a table: searched, filtered, and accepted or rejected many at a time. */
import { addressOf, reviewPage } from '../collecting/addresses.ts';
import type { Collection, Work } from '../collecting/collections.ts';
import { action, field } from '../elements/forms.ts';
import { counted, dateTime, make, problems, say, table, toast } from '../elements/page.ts';
import { api, json } from '../server/api.ts';
import { Filters } from './filters.ts';
import { duration, hintsOf, outcomeOf, type State, stateTexts } from './words.ts';

const perPage = 50;
/** The most that the server takes at once. */
const mostAtOnce = 500;
const pauseMs = 300;
const badges: Readonly<Record<State, string>> = { submitted: 'badge wait', accepted: 'badge good', rejected: 'badge bad' };

/** What a row shows of work: its text, or what was looked for. */
export const textOf = ({ instruction, object }: Work): string =>
  [object?.name, instruction].filter((part) => part).join(': ') || 'No text';

class Texts {
  private readonly collection: Collection;
  private readonly filters: Filters;
  private readonly search = make('input', { type: 'search' });
  private readonly found = make('p', { role: 'status', class: 'note' });
  private readonly rows = make('div', { class: 'texts' });
  private readonly said = make('div');
  private readonly more: HTMLButtonElement;
  private readonly all = make('input', { type: 'checkbox' });
  private readonly accept: HTMLButtonElement;
  private readonly reject: HTMLButtonElement;
  private readonly why: HTMLElement;
  private readonly reason: HTMLInputElement;
  private readonly ticks = new Map<number, HTMLInputElement>();
  private list: Work[] = [];
  private matching = 0;
  /** Counts requests: an answer that comes late is not shown. */
  private asked = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(main: HTMLElement, collection: Collection) {
    this.collection = collection;
    this.filters = new Filters(collection.collection, 'all', () => this.reload());
    this.search.value = new URLSearchParams(location.search).get('q') ?? '';
    this.search.addEventListener('input', () => {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => {
        const query = new URLSearchParams(location.search);
        if (this.search.value) query.set('q', this.search.value);
        else query.delete('q');
        history.replaceState(null, '', `?${query}`);
        this.reload();
      }, pauseMs);
    });
    this.more = action('Show more', this.said, () => this.fetch());
    this.accept = action('Accept', this.said, () => this.judge('accepted'), { class: 'main' });
    this.reject = action('Reject', this.said, () => this.judge('rejected'));
    [this.why, this.reason] = field('reason', 'Why, if you reject them (the workers read this)', { maxlength: '500' });
    this.reason.required = false;
    this.all.addEventListener('change', () => {
      for (const tick of this.ticks.values()) if (!tick.disabled) tick.checked = this.all.checked;
      this.chosen();
    });
    main.append(
      make('div', { class: 'toolbar' }, make('div', { class: 'field grow' }, make('label', { for: 'search' }, 'Search in all texts'), this.search)),
      this.filters.element, this.found, this.rows, make('p', { class: 'buttons' }, this.more),
      make('div', { class: 'batch' }, make('p', { class: 'buttons' },
        make('label', { class: 'row' }, this.all, 'All shown that wait for review'), this.accept, this.reject), this.why, this.said));
    this.search.id = 'search';
  }

  async open(): Promise<void> {
    await this.filters.open();
    await this.load();
  }

  private reload(): void {
    this.load().catch((error: unknown) => this.said.replaceChildren(problems(error)));
  }

  private async load(): Promise<void> {
    this.list = [];
    this.said.replaceChildren();
    await this.fetch();
  }

  private async fetch(): Promise<void> {
    const asked = ++this.asked;
    const query = new URLSearchParams({ ...this.filters.query(), ...(this.search.value && { q: this.search.value }),
      after: String(this.list.at(-1)?.task ?? 0), limit: String(perPage) });
    const found = await api.call<{ matching: number; work: Work[] }>(`${addressOf(this.collection.collection)}/work?${query}`);
    if (asked !== this.asked) return;
    this.matching = found.matching;
    this.list.push(...found.work);
    this.show();
  }

  private show(): void {
    const chosen = new Set(this.selected());
    this.ticks.clear();
    const all = this.matching.toLocaleString('en-US');
    say(this.found, this.matching === 0 ? 'No work matches.' : `${counted(this.list.length, 'task')} of ${all} that match.`);
    this.all.checked = false;
    const cell = (label: string, content: Node | string, name = '') => make('td', { 'data-label': label, ...(name && { class: name }) }, content);
    const head = ['Select', 'Task', 'Text', 'Worker', 'Path', 'Time', 'State', 'Hints'];
    this.rows.replaceChildren(...(this.list.length === 0 ? [] : [table(head, this.list.map((work) => [
      make('td', {}, this.tickOf(work, chosen)),
      cell('Task', this.linkTo(work)), cell('Text', textOf(work), 'wide text'), cell('Worker', String(work.worker), 'number'),
      cell('Path', String(work.path_id), 'number'), cell('Time', duration(work.seconds ?? work.page_seconds), 'number'),
      cell('State', make('span', { class: badges[work.state], title: dateTime(work.submitted) }, stateTexts[work.state]), 'half'),
      cell('Hints', [outcomeOf(work), ...hintsOf(work)].filter((part) => part).join(', '), 'half')]), { kind: 'stack', label: 'Submitted work' })]));
    this.more.hidden = this.list.length >= this.matching;
    this.chosen();
  }

  private tickOf(work: Work, chosen: ReadonlySet<number>): HTMLInputElement {
    const tick = make('input', { type: 'checkbox', 'aria-label': `Select task ${work.task}` });
    tick.disabled = work.state !== 'submitted';
    tick.checked = chosen.has(work.task) && !tick.disabled;
    tick.addEventListener('change', () => this.chosen());
    this.ticks.set(work.task, tick);
    return tick;
  }

  /** To the task on its path. */
  private linkTo({ task, worker, path_id }: Work): HTMLElement {
    const href = reviewPage(this.collection.collection, { state: 'all', worker: String(worker), path: String(path_id) });
    return make('a', { href, 'aria-label': `Task ${task} on its path` }, String(task));
  }

  private selected(): number[] {
    return [...this.ticks].filter(([, tick]) => tick.checked).map(([task]) => task);
  }

  private chosen(): void {
    const { length } = this.selected();
    this.accept.textContent = length > 0 ? `Accept ${length}` : 'Accept';
    this.reject.textContent = length > 0 ? `Reject ${length}` : 'Reject';
    this.accept.disabled = this.reject.disabled = length === 0;
    this.why.hidden = length === 0;
  }

  private async judge(verdict: 'accepted' | 'rejected'): Promise<void> {
    const tasks = this.selected();
    const reason = this.reason.value.trim();
    if (verdict === 'rejected' && reason === '') {
      this.reason.focus();
      throw new Error('A rejection needs a reason.');
    }
    if (tasks.length > mostAtOnce) throw new Error(`${tasks.length} tasks are chosen; ${mostAtOnce} at once are the most.`);
    await api.call(`${addressOf(this.collection.collection)}/reviews`,
      json({ tasks, verdict, ...(verdict === 'rejected' && { reason }) }, 'PUT'));
    this.reason.value = '';
    toast(`${counted(tasks.length, 'task')} ${verdict}.`);
    this.ticks.clear();
    await this.load();
  }
}

export async function showTexts(main: HTMLElement, collection: Collection): Promise<void> {
  await new Texts(main, collection).open();
}
