/** The leaderboard of a phase: `/leaderboard?phase=P`. */
import { addSiteHeader, api, byId, make, problems, run, table } from '../page.ts';

interface Mean { readonly mean: number | null; readonly low: number | null; readonly high: number | null }
interface Row {
  readonly id: number;
  readonly team: string;
  readonly method: string;
  readonly created: string;
  readonly means: Readonly<Record<string, Mean>>;
}
interface Phase {
  readonly phase: string;
  readonly title: string;
  readonly split: string;
  readonly episodes: number;
  readonly scores: 'public' | 'hidden';
}

/** Column, its heading, what it is, its unit, and whether more is better. */
const columns = [
  ['trajectory_length', 'TL', 'Trajectory length, metres', 1, false],
  ['nav_error', 'NE', 'Navigation error, metres', 1, false],
  ['success', 'SR', 'Success rate, per cent', 100, true],
  ['oracle_success', 'OSR', 'Oracle success rate, per cent', 100, true],
  ['spl', 'SPL', 'Success weighted by path length, per cent', 100, true],
  ['ndtw_collapsed', 'nDTW', 'Normalised dynamic time warping, per cent', 100, true],
  ['sdtw_collapsed', 'sDTW', 'Success weighted by nDTW, per cent', 100, true],
  ['cls', 'CLS', 'Coverage weighted by length score, per cent', 100, true],
] as const;
type Column = (typeof columns)[number];

const show = (value: number | null | undefined, unit: number): string =>
  value === null || value === undefined ? '–' : (value * unit).toFixed(unit === 1 ? 2 : 1);

function cellOf(row: Row, [name, , , unit]: Column): HTMLElement {
  const { mean, low, high } = row.means[name]!;
  return make('td', { class: 'number' }, show(mean, unit),
    make('span', { class: 'interval' }, `${show(low, unit)}–${show(high, unit)}`));
}

function draw(box: HTMLElement, rows: readonly Row[], sorted: Column): void {
  const value = (row: Row) => row.means[sorted[0]]?.mean ?? (sorted[4] ? -Infinity : Infinity);
  const order = [...rows].sort((a, b) => (sorted[4] ? value(b) - value(a) : value(a) - value(b)));
  const heads = columns.map((column) => {
    const button = make('button', { type: 'button', title: column[2] }, column[1]);
    button.addEventListener('click', () => {
      draw(box, rows, column);
      box.querySelectorAll<HTMLElement>('th button')[columns.indexOf(column)]?.focus();
    });
    const here = column === sorted;
    return make('th', { scope: 'col', class: 'number', 'aria-sort': !here ? 'none' : sorted[4] ? 'descending' : 'ascending' },
      button, here ? (sorted[4] ? ' ▾' : ' ▴') : '');
  });
  box.replaceChildren(table(['Team', 'Method', ...heads, 'Handed in'], order.map((row) => [
    row.team, row.method, ...columns.map((column) => cellOf(row, column)), make('td', { class: 'date' }, row.created.slice(0, 10)),
  ])));
}

run(async () => {
  await addSiteHeader();
  const { phases } = await api.call<{ phases: Phase[] }>('phases');
  const main = byId('main');
  main.append(make('h1', {}, 'Leaderboard'));
  if (phases.length === 0) {
    main.append(make('p', {}, 'Nothing is scored here: this data set has no split with goals.'));
    return;
  }
  const select = make('select', { id: 'phase' }, ...phases.map((p) => new Option(p.title, p.phase)));
  const wanted = new URLSearchParams(location.search).get('phase');
  if (phases.some((p) => p.phase === wanted)) select.value = wanted!;
  const box = make('div', { 'aria-live': 'polite' });
  const load = async (): Promise<void> => {
    const phase = phases.find((p) => p.phase === select.value)!;
    const name = encodeURIComponent(phase.phase);
    const { rows } = await api.call<{ rows: Row[] }>(`leaderboards/${name}`);
    const list = make('div');
    draw(list, rows, columns[4]);
    box.replaceChildren(
      make('p', { class: 'note' }, `Split ${phase.split}, ${phase.episodes} instructions. Each team's best by SPL, with bootstrap 95 % intervals over paths.`),
      rows.length === 0 ? make('p', {}, 'Nobody has handed anything in yet.') : list,
      make('p', {}, make('a', { href: `/api/v1/leaderboards/${name}?format=csv&all=1`, download: `${phase.phase}.csv` }, 'All submissions as a sheet (CSV)')));
  };
  const refresh = () => { load().catch((error: unknown) => box.replaceChildren(problems(error))); };
  select.addEventListener('change', refresh);
  main.append(make('label', { for: 'phase' }, 'Phase'), select, box);
  refresh();
});
