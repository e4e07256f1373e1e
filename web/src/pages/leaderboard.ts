/** The page of a benchmark's phase: results, progress, rules. `/leaderboard?phase=P&sort=nav_error` */
import { intervalBar, type Point, progressChart, scaleOf } from '../elements/charts.ts';
import { labelled, type Who } from '../elements/forms.ts';
import { markdown } from '../elements/markdown.ts';
import {
  addSiteHeader, byId, counted, empty, facts, loading, make, problems, run, table,
} from '../elements/page.ts';
import {
  benchmarkOf, leakageNote, limitsOf, type Phase, type PhaseList, primaryName, primaryOf, showingOf,
} from '../evaluation/phases.ts';
import {
  bestText, type Column, type Direction, factorOf, firstDirection, format, places, type Row, sorted, unitOf, valueOf,
} from '../evaluation/ranking.ts';
import { api, ServerError } from '../server/api.ts';

interface Order {
  readonly by: Column;
  readonly direction: Direction;
}

/** Mean and interval, in the column's unit; nothing where there is no interval. */
function intervalOf(row: Row, column: Column) {
  const { low, mean, high } = row.means[column.name] ?? { mean: null };
  if (typeof low !== 'number' || typeof high !== 'number' || mean === null) return undefined;
  const factor = factorOf(column);
  return { low: low * factor, mean: mean * factor, high: high * factor };
}

/** The cells of a column. */
function cellsOf(rows: readonly Row[], column: Column): HTMLElement[] {
  const best = bestText(rows, column);
  const intervals = rows.map((row) => intervalOf(row, column));
  const scale = scaleOf(intervals.flatMap((one) => one ?? []));
  return rows.map((row, k) => {
    const text = format(valueOf(row, column), column);
    const cell = make('td', { class: text === best ? 'number best' : 'number', 'data-label': `${column.short}, ${unitOf(column)}` }, text);
    const interval = intervals[k];
    if (interval) cell.append(intervalBar(interval, scale, `95 % interval ${format(interval.low, column)} to ${format(interval.high, column)}`));
    return cell;
  });
}

function teamCell({ team, method, paper, code }: Row): HTMLElement {
  const link = (href: string, text: string) => make('a', { href, rel: 'noopener noreferrer nofollow', 'aria-label': `${text} of ${method}` }, text);
  const links = [...(paper ? [link(paper, 'Paper')] : []), ...(code ? [link(code, 'Code')] : [])];
  return make('td', { class: 'rest' }, make('strong', {}, team), make('span', { class: 'method' }, method, ...links.flatMap((one) => [' ', one])));
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

function drawRows(box: HTMLElement, all: readonly Row[], phase: Phase, order: Order): void {
  const primary = primaryOf(phase);
  const place = new Map(places(all, primary).map((one, k) => [all[k]!.id, one]));
  const shown = phase.columns.filter((column) => all.some((row) => row.means[column.name] !== undefined));
  const rows = sorted(all, order.by, order.direction);
  const heads = shown.map((column) => {
    const here = column === order.by;
    const button = make('button', { type: 'button', title: column.title }, column.short);
    button.addEventListener('click', () => {
      const turned = order.direction === 'ascending' ? 'descending' : 'ascending';
      const next = { by: column, direction: here ? turned : firstDirection(column) } as const;
      keepOrder(next);
      drawRows(box, all, phase, next);
      box.querySelectorAll<HTMLElement>('th button')[shown.indexOf(column)]?.focus();
    });
    return make('th', { scope: 'col', class: 'number', 'aria-sort': here ? order.direction : 'none' }, button, make('span', { class: 'unit' }, unitOf(column)));
  });
  const cells = shown.map((column) => cellsOf(rows, column));
  box.replaceChildren(table([make('th', { scope: 'col', 'aria-label': 'Rank' }, '#'), 'Team and method', ...heads, make('th', { scope: 'col', class: 'number' }, 'Submitted')],
    rows.map((row, k) => [make('td', { class: 'rank' }, String(place.get(row.id))), teamCell(row), ...cells.map((list) => list[k]!),
      make('td', { class: 'number date wide', 'data-label': 'Submitted' }, row.created.slice(0, 10))]),
    { kind: 'stack', label: `Results of ${phase.title}` }));
}

/** The rows, or why there are none to be seen. */
async function boardOf(phase: Phase, organiser: boolean, all: boolean): Promise<readonly Row[] | string> {
  const none = 'Scores are shown when the phase has ended.';
  if (!organiser && phase.scores === 'hidden') return 'Only the organisers see the scores of this phase.';
  if (!organiser && phase.scores === 'after-end' && !phase.ended) return none;
  try {
    return (await api.call<{ rows: Row[] }>(`leaderboards/${encodeURIComponent(phase.phase)}${all ? '?all=1' : ''}`)).rows;
  } catch (error) {
    if (error instanceof ServerError && error.status === 403) return 'The last files are being scored.';
    throw error;
  }
}

/** What a team has reached, submission by submission. */
function progressOf(rows: readonly Row[], phase: Phase): HTMLElement[] {
  const primary = primaryOf(phase);
  const points: Point[] = rows.flatMap((row) => {
    const value = valueOf(row, primary);
    return value === undefined ? [] : [{ team: row.team, time: Date.parse(row.created), value, name: row.method }];
  });
  const teams = [...new Set(points.map(({ team }) => team))]; // best first, as the rows are
  if (points.length < 2) return [];
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

async function fill(box: HTMLElement, phase: Phase, organiser: boolean): Promise<void> {
  const open = !phase.goals_secret || organiser;
  const [board, all] = await Promise.all([boardOf(phase, organiser, false), open ? boardOf(phase, organiser, true) : []]);
  const heading = make('h2', {}, 'Results');
  if (typeof board === 'string') return box.replaceChildren(heading, empty('No scores yet', board));
  if (board.length === 0) return box.replaceChildren(heading, empty('No results yet', 'There are no submissions.'));
  const results = make('div');
  drawRows(results, board, phase, orderOf(new URLSearchParams(location.search).get('sort'), phase, primaryOf(phase)));
  const file = `/api/v1/leaderboards/${encodeURIComponent(phase.phase)}?format=csv&all=1`;
  const about = `Each team's best by ${primaryName(phase)}${open ? '; bars are bootstrap 95 % intervals over paths' : ''}. `;
  box.replaceChildren(heading, results,
    make('p', { class: 'note' }, about, make('a', { href: file, download: `${phase.phase}.csv` }, open ? 'All submissions (CSV)' : 'Table (CSV)')),
    ...progressOf(typeof all === 'string' ? [] : all, phase));
}

run(async () => {
  await addSiteHeader();
  const main = byId('main');
  const [{ phases }, who] = await Promise.all([api.call<PhaseList>('phases'), api.call<Who>('session')]);
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
  const organiser = who.role === 'organiser';
  const results = make('section', { 'aria-live': 'polite' }, loading());
  main.append(headOf(phase, organiser), results);
  if (phase.rules) main.append(make('h2', { id: 'rules' }, 'Rules'), markdown(phase.rules));
  await fill(results, phase, organiser).catch((error: unknown) => results.replaceChildren(problems(error)));
});
