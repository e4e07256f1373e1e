/** The page of a benchmark's phase: results, progress, rules. `/leaderboard?phase=P&sort=nav_error#submission-3` */
import { type Point, progressChart } from '../elements/charts.ts';
import { labelled, type Who } from '../elements/forms.ts';
import { markdown } from '../elements/markdown.ts';
import {
  addSiteHeader, byId, counted, empty, facts, loading, make, problems, run, table,
} from '../elements/page.ts';
import { comparisonBox } from '../evaluation/comparison.ts';
import { copied, methodLink, methodLinks } from '../evaluation/method.ts';
import { ownTeam } from '../evaluation/own_team.ts';
import {
  benchmarkOf, commandsOf, inOrder, leakageNote, limitsOf, type Phase, type PhaseList, primaryName, primaryOf, showingOf,
} from '../evaluation/phases.ts';
import {
  type Column, type Direction, firstDirection, format, places, type Published, type Row, sorted, unitOf, valueOf,
} from '../evaluation/ranking.ts';
import { scoreCells } from '../evaluation/scores.ts';
import { api, ServerError } from '../server/api.ts';
import '../evaluation/evaluation.css';

/** What a leaderboard has, as far as one may see it. */
interface Board {
  readonly rows: readonly Row[];
  readonly published: readonly Published[];
}

interface Order {
  readonly by: Column;
  readonly direction: Direction;
}

/** Who made it, what it is, where it is described. @param yours whether the row is of the reader's team */
function teamCell(row: Row, yours: boolean): HTMLElement {
  const parts = [...methodLinks(row), ...(row.weights === 'open' ? [make('span', { class: 'badge' }, 'open weights')] : [])];
  return make('td', { class: 'rest' }, make('strong', {}, row.team), ...(yours ? [make('span', { class: 'badge good' }, 'yours')] : []),
    make('span', { class: 'method' }, make('a', { href: methodLink(row.id) }, row.method), ...parts.flatMap((one) => [' ', one])));
}

function publishedCell({ agent, source }: Published): HTMLElement {
  return make('td', { class: 'rest' }, make('strong', {}, agent), make('span', { class: 'badge' }, 'published'),
    make('span', { class: 'method' }, source));
}

/** The address says how the table is sorted: a link shows what its sender saw. */
function keepOrder({ by, direction }: Order): void {
  const query = new URLSearchParams(location.search);
  query.set('sort', direction === firstDirection(by) ? by.name : `${by.name}-${direction}`);
  history.replaceState(null, '', `?${query}`);
}

function orderOf(text: string | null, { columns }: Phase, otherwise: Column): Order {
  const [name, direction] = (text ?? '').split('-');
  const by = columns.find((column) => column.name === name) ?? otherwise;
  return { by, direction: direction === 'ascending' || direction === 'descending' ? direction : firstDirection(by) };
}

/** The row that the address names comes into sight. */
function showTarget(box: HTMLElement, rows: readonly Row[]): void {
  const id = Number(/^#submission-(\d+)$/.exec(location.hash)?.[1]);
  if (!id) return;
  const row = document.getElementById(`submission-${id}`);
  for (const other of box.querySelectorAll('.target')) other.classList.remove('target');
  row?.classList.add('target');
  row?.scrollIntoView({ block: 'center' });
  if (rows.some((one) => one.id === id)) return;
  box.append(make('p', { class: 'note' }, `Submission ${id} has no row here: another one stands for its team. `,
    make('a', { href: methodLink(id) }, 'Its page')));
}

/** @param team the reader's */
function drawRows(box: HTMLElement, board: Board, phase: Phase, order: Order, team: string | undefined): void {
  const { rows: own, published } = board;
  const primary = primaryOf(phase);
  const place = new Map(places(own, primary).map((one, k) => [own[k]!, one]));
  const shown = phase.columns.filter((column) => own.some((row) => row.means[column.name] !== undefined));
  const rows = sorted<Row | Published>([...own, ...published], order.by, order.direction);
  const heads = shown.map((column) => {
    const here = column === order.by;
    const button = make('button', { type: 'button', title: column.title }, column.short);
    button.addEventListener('click', () => {
      const turned = order.direction === 'ascending' ? 'descending' : 'ascending';
      const next = { by: column, direction: here ? turned : firstDirection(column) } as const;
      keepOrder(next);
      drawRows(box, board, phase, next, team);
      box.querySelectorAll<HTMLElement>('th button')[shown.indexOf(column)]?.focus();
    });
    return make('th', { scope: 'col', class: 'number', 'aria-sort': here ? order.direction : 'none' }, button, make('span', { class: 'unit' }, unitOf(column)));
  });
  const cells = shown.map((column) => scoreCells(rows, column, own));
  const numbers = (k: number) => cells.map((list) => list[k]!);
  const date = (text: string) => make('td', { class: 'number date wide', 'data-label': 'Submitted' }, text);
  const lines = rows.map((row, k) => ('id' in row
    ? [make('td', { class: 'rank' }, String(place.get(row))), teamCell(row, row.team === team), ...numbers(k), date(row.created.slice(0, 10))]
    : [make('td', { class: 'rank' }, '–'), publishedCell(row), ...numbers(k), date('–')]));
  const submitted = make('th', { scope: 'col', class: 'number' }, 'Submitted');
  box.replaceChildren(table([make('th', { scope: 'col', 'aria-label': 'Rank' }, '#'), 'Team and method', ...heads, submitted], lines,
    { kind: 'stack', label: `Results of ${phase.title}` }));
  box.querySelectorAll('tbody tr').forEach((line, k) => {
    const row = rows[k]!;
    if ('id' in row) line.id = `submission-${row.id}`;
    line.classList.toggle('yours', 'id' in row && row.team === team);
    line.classList.toggle('published', !('id' in row));
  });
}

/** The rows, or why there are none to be seen. */
async function boardOf(phase: Phase, organiser: boolean, all: boolean): Promise<Board | string> {
  const none = 'Scores are shown when the phase has ended.';
  if (!organiser && phase.scores === 'hidden') return 'Only the organisers see the scores of this phase.';
  if (!organiser && phase.scores === 'after-end' && !phase.ended) return none;
  try {
    return await api.call<Board>(`leaderboards/${encodeURIComponent(phase.phase)}${all ? '?all=1' : ''}`);
  } catch (error) {
    if (error instanceof ServerError && error.status === 403) return 'The last files are being scored.';
    throw error;
  }
}

/** What a team has reached, submission by submission; nothing where no team has submitted twice. */
function progressOf(rows: readonly Row[], phase: Phase): HTMLElement[] {
  const primary = primaryOf(phase);
  const points: Point[] = rows.flatMap((row) => {
    const value = valueOf(row, primary);
    return value === undefined ? [] : [{ team: row.team, time: Date.parse(row.created), value, name: row.method }];
  });
  const count = (name: string) => points.filter(({ team }) => team === name).length;
  const teams = [...new Set(points.map(({ team }) => team))].filter((name) => count(name) > 1); // best first, as the rows are
  if (teams.length === 0) return [];
  const [box, team] = labelled('progress-team', 'Team', make('select', {}, ...teams.map((name) => new Option(name, name))));
  const chart = make('div');
  const show = () => {
    const own = points.filter((point) => point.team === team.value);
    const best = Math.max(...own.map(({ value }) => value));
    const label = `${primary.short} of ${team.value} over time: ${counted(own.length, 'submission')}, best ${format(best, primary)} ${unitOf(primary)}`;
    chart.replaceChildren(progressChart(points, team.value, label),
      make('p', { class: 'note' }, `${label}. Filled dots: better than before; grey lines: other teams.`));
  };
  team.addEventListener('change', show);
  show();
  return [make('h2', { id: 'progress' }, 'Progress'), make('div', { class: 'toolbar' }, box), chart];
}

/** What is to be known of a phase above its table. */
function headOf(phase: Phase, organiser: boolean): HTMLElement {
  const ends = phase.ends === null ? (phase.ended ? 'ended' : 'open') : phase.ends.slice(0, 16).replace('T', ' ');
  const secret = [showingOf(phase),
    phase.near_copies ? `${phase.near_copies} submissions end where an earlier one does, in all but a few episodes: the page Submit marks them.` : ''];
  const links = [make('a', { href: `/submit?${new URLSearchParams({ phase: phase.phase })}`, class: 'button main' }, 'Submit results'),
    ...(phase.rules ? [make('a', { href: '#rules', class: 'button' }, 'Rules')] : [])];
  return make('div', {},
    facts([['Benchmark', benchmarkOf(phase)], ['Split', phase.split], ['Instructions', phase.episodes.toLocaleString('en-US')], ['Ranked by', primaryName(phase)],
      ['Submissions of a team', limitsOf(phase)], [phase.ends === null || !phase.ended ? (phase.ends === null ? 'State' : 'Ends, UTC') : 'Ended, UTC', ends]]),
    ...secret.filter((text) => text !== '').map((text) => make('p', { class: 'note' }, text)), ...leakageNote(phase),
    ...(organiser && phase.goals_secret ? [make('p', { class: 'notice' }, 'You see all scores as an organiser; teams and visitors do not.')] : []),
    make('p', { class: 'buttons' }, ...links));
}

/** How to submit, on the page of a phase without submissions. */
const noResults = (phase: Phase): HTMLElement => make('div', { class: 'empty' }, make('h2', {}, 'No results yet'),
  make('p', {}, 'The first submission takes two commands, or the page Submit and a results file. ',
    'A team has its token from the page Submit or the organisers.'),
  copied(commandsOf(phase, location.origin), 'Commands that make a submission'));

async function fill(box: HTMLElement, phase: Phase, who: Who): Promise<void> {
  const organiser = who.role === 'organiser';
  const open = !phase.goals_secret || organiser;
  const [board, all] = await Promise.all([boardOf(phase, organiser, false), open ? boardOf(phase, organiser, true) : 'not all are seen']);
  const heading = make('h2', {}, 'Results');
  if (typeof board === 'string') return box.replaceChildren(heading, empty('No scores yet', board));
  if (board.rows.length === 0) return box.replaceChildren(heading, noResults(phase));
  const results = make('div');
  const draw = () => {
    drawRows(results, board, phase, orderOf(new URLSearchParams(location.search).get('sort'), phase, primaryOf(phase)), ownTeam(who));
  };
  draw();
  const file = `/api/v1/leaderboards/${encodeURIComponent(phase.phase)}?format=csv&all=1`;
  const about = `Each team's best by ${primaryName(phase)}${open ? '; bars are bootstrap 95 % intervals over paths' : ''}. `
    + `${board.published.length > 0 ? 'Grey rows are figures that others have published, with where they were read; they have no rank. ' : ''}`;
  const every = typeof all === 'string' ? [] : all.rows;
  box.replaceChildren(heading, results,
    make('p', { class: 'note' }, about, make('a', { href: file, download: `${phase.phase}.csv` }, open ? 'All submissions (CSV)' : 'Table (CSV)')),
    ...comparisonBox(phase, every.length > 0 ? every : board.rows), ...progressOf(every, phase));
  showTarget(results, board.rows);
  addEventListener('hashchange', () => {
    draw();
    showTarget(results, board.rows);
  });
}

run(async () => {
  await addSiteHeader();
  const main = byId('main');
  const [list, who] = await Promise.all([api.call<PhaseList>('phases'), api.call<Who>('session')]);
  const phases = inOrder(list.phases);
  main.append(make('h1', {}, 'Leaderboard'));
  if (phases.length === 0) {
    main.append(empty('Nothing is scored here', 'This data set has no split with goals.'));
    return;
  }
  const wanted = new URLSearchParams(location.search).get('phase');
  const phase = phases.find((one) => one.phase === wanted) ?? phases[0]!;
  if (phases.length > 1) {
    main.append(make('nav', { class: 'tabs', 'aria-label': 'Phases' }, ...phases.map((one) =>
      make('a', { href: `?${new URLSearchParams({ phase: one.phase })}`, ...(one === phase && { 'aria-current': 'page' }) }, one.title))));
  }
  document.title = `${phase.title}: leaderboard · Enfilade`;
  const results = make('section', { 'aria-live': 'polite' }, loading());
  main.append(headOf(phase, who.role === 'organiser'), results);
  if (phase.rules) main.append(make('h2', { id: 'rules' }, 'Rules'), markdown(phase.rules));
  await fill(results, phase, who).catch((error: unknown) => results.replaceChildren(problems(error)));
});
