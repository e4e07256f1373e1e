/** The episodes of one run: `/replay?run=R&show=failures&sort=spl-descending`. */
import { labelled } from '../elements/forms.ts';
import { addSiteHeader, counted, crumbs, empty, facts, type Link, make, problems, table } from '../elements/page.ts';
import { shownText } from '../episodes/episode.ts';
import { episodePage } from '../episodes/splits.ts';
import { api } from '../server/api.ts';
import { type Direction, type Order, orderText, parseOrder, runColumns, sortHeading } from './columns.ts';
import {
  address, endText, type EpisodeList, keyOfRun, type ListedEpisode, type Measures, type Run, runPath, type Score,
} from './runs.ts';

export const runsPage: Link = ['/replay', 'Runs'];
const perPage = 200;

/** What the server sorts by, and its heading. */
interface ListColumn {
  readonly sort: string;
  readonly name: string;
  readonly title: string;
  readonly first: Direction;
}
const column = (sort: string, name: string, title: string, first: Direction = 'descending'): ListColumn => ({ sort, name, title, first });
const episodeColumn = column('episode', 'Episode', 'The id of the instruction', 'ascending');
const scoreColumns = [column('success', 'Result', 'Success, and the navigation error', 'ascending'),
  column('spl', 'SPL', 'Success weighted by path length', 'ascending')];
const otherColumns = [column('steps', 'Steps', 'Accepted calls'), column('mistakes', 'Mistakes', 'Calls that were not accepted'),
  column('tokens', 'Tokens', 'Tokens in and out')];

/** Which episodes are listed, by the server's names. */
const shows: Readonly<Record<string, string>> = {
  all: 'All episodes', failures: 'Failures', successes: 'Successes', mistakes: 'With a mistake', unstopped: 'Without a stop',
};

/** What the address says of the list. */
interface Query {
  readonly show: string;
  readonly order: Order;
  readonly offset: number;
}

function readQuery(columns: readonly ListColumn[]): Query {
  const query = new URLSearchParams(location.search);
  const show = query.get('show') ?? 'all';
  return {
    show: Object.hasOwn(shows, show) ? show : 'all',
    order: parseOrder(query.get('sort'), columns.map(({ sort, first }) => ({ name: sort, first }))) ?? { by: 'episode', direction: 'ascending' },
    offset: Math.max(0, Math.trunc(Number(query.get('offset'))) || 0),
  };
}

/** The address of a list: without what is usual. */
function queryText(run: string, { show, order, offset }: Query, columns: readonly ListColumn[]): string {
  const sort = orderText(order, columns.find(({ sort: name }) => name === order.by)?.first ?? 'ascending');
  return address({ run, ...(show !== 'all' && { show }), ...(sort !== 'episode' && { sort }), ...(offset > 0 && { offset: String(offset) }) });
}

/** "success" with its distance, as a badge and a number. */
export function resultCell({ success, nav_error: error }: Score, label = 'Result'): HTMLElement {
  if (success === undefined) return make('td', { class: 'half', 'data-label': label }, '–');
  return make('td', { class: 'half', 'data-label': label },
    make('span', { class: success ? 'badge good' : 'badge bad' }, success ? 'success' : 'failure'),
    ...(error === undefined ? [] : [make('span', { class: 'method' }, `${error.toFixed(1)} m from the goal`)]));
}

class EpisodeTable {
  readonly element = make('div', { 'aria-live': 'polite' });
  private readonly run: Run;
  private readonly columns: readonly ListColumn[];
  private query: Query;
  /** Counts what was asked for: only the last answer is shown. */
  private asked = 0;

  constructor(run: Run) {
    this.run = run;
    this.columns = [episodeColumn, ...(run.outcomes ? scoreColumns : []), ...otherColumns];
    this.query = readQuery(this.columns);
  }

  /** The choice of episodes. Failures are known only where success is. */
  filter(): HTMLElement {
    const offered = Object.entries(shows).filter(([name]) => this.run.outcomes || (name !== 'failures' && name !== 'successes'));
    const [box, select] = labelled('show', 'Show', make('select', {}, ...offered.map(([name, text]) => new Option(text, name))));
    select.value = this.query.show;
    if (select.value !== this.query.show) this.query = { ...this.query, show: select.value = 'all' };
    select.addEventListener('change', () => void this.change({ show: select.value, offset: 0 }));
    return box;
  }

  async change(parts: Partial<Query>): Promise<void> {
    this.query = { ...this.query, ...parts };
    history.replaceState(null, '', queryText(this.run.run, this.query, this.columns));
    const focused = (document.activeElement as HTMLElement | null)?.closest('th')?.querySelector('button')?.textContent;
    await this.fill();
    [...this.element.querySelectorAll<HTMLElement>('th button')].find(({ textContent }) => textContent === focused)?.focus();
  }

  async fill(): Promise<void> {
    const number = ++this.asked;
    const { show, order: { by, direction }, offset } = this.query;
    const descending = direction === 'descending' ? '1' : '0';
    const query = new URLSearchParams({ show, sort: by, descending, offset: String(offset), limit: String(perPage) });
    try {
      const found = await api.call<EpisodeList>(`${runPath(this.run.run)}?${query}`);
      if (number === this.asked) this.draw(found);
    } catch (error) {
      if (number === this.asked) this.element.replaceChildren(problems(error));
    }
  }

  private draw({ matching, list }: EpisodeList): void {
    const { show, offset } = this.query;
    if (list.length === 0 && offset > 0) return void this.change({ offset: 0 }); // the address names a page that is no more
    if (list.length === 0) {
      this.element.replaceChildren(this.run.episodes === 0 ? empty('No episodes', 'This run has no finished episode.')
        : empty('No such episode', `The run has none of the kind: ${shows[show]!.toLowerCase()}.`));
      return;
    }
    const byName = new Map(this.columns.map((one) => [one.name, one]));
    const head = (name: string, number = true) => {
      const one = byName.get(name)!;
      const order = this.query.order.by === one.sort ? { by: name, direction: this.query.order.direction } : undefined;
      return sortHeading(one, order, ({ direction }) => void this.change({ order: { by: one.sort, direction }, offset: 0 }), number);
    };
    const heads = [head('Episode', false), 'Instruction', ...(this.run.outcomes ? [head('Result', false), head('SPL')] : []), 'How it ended',
      ...otherColumns.map(({ name }) => head(name))];
    const turn = (text: string, to: number) => {
      const button = make('button', { type: 'button' }, text);
      button.addEventListener('click', () => void this.change({ offset: to }));
      return button;
    };
    const to = offset + list.length;
    this.element.replaceChildren(
      table(heads, list.map((one) => this.row(one)), { kind: 'stack', label: `Episodes of ${this.run.run}` }),
      ...(matching > perPage || offset > 0 ? [make('p', { class: 'pages' }, ...(offset > 0 ? [turn('Previous', Math.max(0, offset - perPage))] : []),
        `${(offset + 1).toLocaleString('en-US')} to ${to.toLocaleString('en-US')} of ${matching.toLocaleString('en-US')}`,
        ...(to < matching ? [turn('Next', to)] : []))] : [make('p', { class: 'note' }, counted(matching, 'episode'))]));
  }

  private row(one: ListedEpisode): HTMLElement[] {
    const { outcomes, run } = this.run;
    const key = keyOfRun(this.run);
    const number = (name: string, value: number | string) =>
      make('td', { class: 'number', 'data-label': name }, typeof value === 'number' ? value.toLocaleString('en-US') : value);
    const first = make('td', { class: 'half' }, make('a', { href: address({ run, episode: one.episode }) }, one.episode));
    const text = make('td', { class: 'wide replay-text' }, shownText(one.instruction ?? '', this.run.task),
      ...(key && outcomes ? [' ', make('a', { href: episodePage(key, one.episode), 'aria-label': `Path of ${one.episode}` }, 'Path')] : []));
    if ('problem' in one) {
      return [first, text, ...(outcomes ? [make('td', {}, '–'), number('SPL', '–')] : []), make('td', { class: 'wide problem' }, one.problem),
        ...otherColumns.map(({ name }) => number(name, '–'))];
    }
    return [first, text, ...(outcomes ? [resultCell(one), number('SPL', one.spl === undefined ? '–' : one.spl.toFixed(2))] : []),
      make('td', { class: 'wide' }, endText(one)), number('Steps', one.steps), number('Mistakes', one.mistakes),
      number('Tokens', one.prompt_tokens + one.answer_tokens)];
  }
}

/** Chooses a run to compare with; leads to the comparison. */
async function compareControl(shown: Run): Promise<HTMLElement | undefined> {
  const { runs } = await api.call<{ runs: Run[] }>('runs');
  const same = runs.filter(({ run, task, split }) => run !== shown.run && task === shown.task && split === shown.split && task !== null);
  if (same.length === 0) return undefined;
  const options = [new Option('Choose a run', ''), ...same.map(({ run }) => new Option(run, run))];
  const [box, select] = labelled('with', 'Compare with', make('select', {}, ...options));
  select.addEventListener('change', () => {
    if (select.value) location.assign(address({ run: shown.run, with: select.value }));
  });
  return box;
}

export async function listEpisodes(main: HTMLElement, name: string): Promise<void> {
  await addSiteHeader();
  const found = await api.call<Measures>(`${runPath(name)}/measures`);
  document.title = `${found.run} · Enfilade`;
  const about = [keyOfRun(found) ?? 'unknown split', found.model && `model ${found.model}`, found.prompt && `prompt ${found.prompt}`]
    .filter(Boolean).join(', ');
  main.append(crumbs([runsPage], found.run), make('div', { class: 'page-head' }, make('h1', {}, found.run), make('p', { class: 'lead' }, about)));
  if (found.problem) main.append(make('p', { class: 'notice' }, found.problem));
  const known = runColumns([found], [found]);
  main.append(facts(known.map((one) => [one.name, `${one.text(found, found)}${one.unit ? ` ${one.unit}` : ''}`] as const)));
  if (found.outcomes && found.scored < found.episodes) {
    const scored = `The means are of ${counted(found.scored, 'episode')}: the others have no result for this server’s split.`;
    main.append(make('p', { class: 'note' }, scored));
  }
  const episodes = new EpisodeTable(found);
  const compare = await compareControl(found);
  main.append(make('div', { class: 'toolbar' }, episodes.filter(), ...(compare ? [compare] : [])), episodes.element);
  await episodes.fill();
}
