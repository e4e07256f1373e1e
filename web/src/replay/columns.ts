/** Columns of tables of runs: their values in words, their order, and the headings that sort by them. */
import { make } from '../elements/page.ts';
import type { Column, Measures, Run } from './runs.ts';

export type Direction = 'ascending' | 'descending';
export interface Order {
  readonly by: string;
  readonly direction: Direction;
}

/** "71.4", "3.25", "12": per cent, metres, numbers. @param value a share from 0 to 1, or metres */
export function valueText(value: number | null | undefined, unit: Column['unit']): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (unit === 'share') return (100 * value).toFixed(1);
  if (unit === 'm') return value.toFixed(2);
  return value.toLocaleString('en-US', { maximumFractionDigits: value < 100 ? 1 : 0 });
}

export const unitText = (unit: Column['unit']): string => ({ share: '%', m: 'm', count: '' })[unit];

/** "0.4 s", "12 s", "2 min", "1.5 h" */
export function timeText(seconds: number): string {
  if (seconds < 120) return `${seconds < 10 ? seconds.toFixed(1) : Math.round(seconds)} s`;
  return seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

/** A column of the table of runs. */
export interface RunColumn {
  readonly name: string;
  readonly title: string;
  readonly unit?: string;
  /** What is best is on top at first. */
  readonly first: Direction;
  /** What it is sorted by; nothing: not known, and last either way. */
  value(run: Run, measures: Measures | undefined): number | string | undefined;
  text(run: Run, measures: Measures | undefined): string;
}

/** Scores by their short names, of all benchmarks; and what ranks in each, if it is none of them. */
const shorts = ['SR', 'SPL', 'NE'];

const scoreOf = (measures: Measures | undefined, short: string) => measures?.scores.find((one) => one.short === short);

function scoreColumn(short: string, known: readonly Measures[]): RunColumn {
  const column = known.map((one) => scoreOf(one, short)).find((one) => one !== undefined);
  const unit = column?.unit ?? (short === 'NE' ? 'm' : 'share');
  const value = (_: Run, measures: Measures | undefined) => scoreOf(measures, short)?.mean ?? undefined;
  return {
    name: short, title: column?.title ?? short, unit: unitText(unit),
    first: (column?.better ?? (short === 'NE' ? 'lower' : 'higher')) === 'lower' ? 'ascending' : 'descending',
    value, text: (run, measures) => valueText(value(run, measures), unit),
  };
}

const plain = (n: number): string => n.toLocaleString('en-US');

function sumColumn(name: string, title: string, value: (measures: Measures) => number | undefined, text = plain): RunColumn {
  return {
    name, title, first: 'ascending', value: (_, measures) => measures && value(measures),
    text: (_, measures) => {
      const found = measures && value(measures);
      return found === undefined ? '–' : text(found);
    },
  };
}

/** Those that the runs have something for. @param known of the runs whose measures came */
export function runColumns(runs: readonly Run[], known: readonly Measures[]): RunColumn[] {
  const ranking = known.flatMap(({ scores }) => scores.slice(0, 1).map(({ short }) => short));
  const scores = runs.some(({ outcomes }) => outcomes) ? [...new Set([...shorts, ...ranking])] : [];
  const some = (value: (measures: Measures) => number | undefined) => known.some((one) => value(one) !== undefined);
  return [
    ...scores.map((short) => scoreColumn(short, known)),
    {
      name: 'Episodes', title: 'Episodes that are done', first: 'descending',
      value: ({ episodes }) => episodes, text: ({ episodes }) => plain(episodes),
    },
    sumColumn('Mistakes', 'Calls that were not accepted', ({ mistakes }) => mistakes),
    sumColumn('Empty', 'Empty responses: without a call', ({ unanswered }) => unanswered),
    sumColumn('Tokens', 'Tokens in and out', (one) => one.prompt_tokens + one.answer_tokens),
    ...(some(({ money }) => money)
      ? [sumColumn('Cost', 'Cost by the prices that the run was given', ({ money }) => money, (n) => n.toFixed(2))] : []),
    ...(some(({ seconds }) => seconds) ? [sumColumn('Time', 'Time of all responses, one after another', ({ seconds }) => seconds, timeText)] : []),
  ];
}

/** In an order; what has no value comes last either way. */
export function sortRuns(
  runs: readonly Run[], measures: ReadonlyMap<string, Measures>, column: Pick<RunColumn, 'value'>, direction: Direction,
): Run[] {
  const sign = direction === 'ascending' ? 1 : -1;
  return [...runs].sort((a, b) => {
    const [x, y] = [a, b].map((one) => column.value(one, measures.get(one.run)));
    if (x === undefined || y === undefined) return Number(x === undefined) - Number(y === undefined);
    return sign * (typeof x === 'string' || typeof y === 'string' ? String(x).localeCompare(String(y)) : x - y);
  });
}

/** "SR", or "SR-ascending" where that is not how the column is sorted first. */
export const orderText = ({ by, direction }: Order, first: Direction): string => (direction === first ? by : `${by}-${direction}`);

/** Its inverse; nothing for an unknown column. */
export function parseOrder(text: string | null, columns: readonly { readonly name: string; readonly first: Direction }[]): Order | undefined {
  const [name, direction] = (text ?? '').split('-');
  const column = columns.find((one) => one.name === name);
  return column && { by: column.name, direction: direction === 'ascending' || direction === 'descending' ? direction : column.first };
}

/** A heading that sorts: pressed again it turns the order round. */
export function sortHeading(
  { name, title, unit = '', first }: Pick<RunColumn, 'name' | 'title' | 'unit' | 'first'>,
  order: Order | undefined, act: (order: Order) => void, number = true,
): HTMLTableCellElement {
  const here = order?.by === name;
  const button = make('button', { type: 'button', title }, name);
  button.addEventListener('click', () => {
    const turned = order?.direction === 'ascending' ? 'descending' : 'ascending';
    act({ by: name, direction: here ? turned : first });
  });
  return make('th', { scope: 'col', 'aria-sort': here ? order.direction : 'none', ...(number && { class: 'number' }) }, button,
    ...(unit ? [make('span', { class: 'unit' }, unit)] : []));
}
