/** The leaderboard's rows: columns, places, orders and best values. */

export interface Mean { readonly mean: number | null; readonly low?: number | null; readonly high?: number | null }
export interface Row {
  readonly id: number;
  readonly team: string;
  readonly method: string;
  readonly created: string;
  readonly paper?: string;
  readonly code?: string;
  /** Whether others can have the method's weights; absent where its team does not say. */
  readonly weights?: 'open' | 'closed';
  /** Whether everybody may see its trajectories. */
  readonly walks_public?: boolean;
  readonly means: Readonly<Record<string, Mean>>;
}

/** What others have published of the benchmark and split. It has no place. */
export interface Published {
  readonly agent: string;
  /** Where it was read. */
  readonly source: string;
  readonly means: Readonly<Record<string, Mean>>;
}

/** A metric of a phase's benchmark, as the server describes it. Shares come from 0 to 1, and are shown as per cent. */
export interface Column {
  /** As the server calls it: where it stands in a row's means. */
  readonly name: string;
  readonly short: string;
  readonly title: string;
  readonly unit: 'm' | 'share';
  /** The better values; none where longer is neither better nor worse. */
  readonly better?: 'higher' | 'lower';
}

export const factorOf = ({ unit }: Column): number => (unit === 'share' ? 100 : 1);
export const unitOf = ({ unit }: Column): string => (unit === 'share' ? '%' : unit);

/** In the column's unit; nothing where it is not shown or not finite. */
export const valueOf = (row: Pick<Row, 'means'>, column: Column): number | undefined => {
  const mean = row.means[column.name]?.mean;
  return mean === undefined || mean === null ? undefined : mean * factorOf(column);
};

export const format = (value: number | undefined, { unit }: Column): string =>
  (value === undefined ? '–' : value.toFixed(unit === 'share' ? 1 : 2));

/** Mean and interval in the column's unit; nothing where there is no interval. */
export function intervalOf(row: Pick<Row, 'means'>, column: Column): { low: number; mean: number; high: number } | undefined {
  const { low, mean, high } = row.means[column.name] ?? { mean: null };
  if (typeof low !== 'number' || typeof high !== 'number' || mean === null) return undefined;
  const factor = factorOf(column);
  return { low: low * factor, mean: mean * factor, high: high * factor };
}

/** "95.1–99.3"; empty without an interval, and where both ends look equal. */
export function rangeText(row: Pick<Row, 'means'>, column: Column): string {
  const interval = intervalOf(row, column);
  if (!interval) return '';
  const [low, high] = [format(interval.low, column), format(interval.high, column)];
  return low === high ? '' : `${low}–${high}`;
}

/** 1 for the best; rows that show the same have the same place. */
export function places(rows: readonly Row[], by: Column): readonly number[] {
  const all = rows.map((row) => valueOf(row, by) ?? -Infinity);
  return all.map((value) => 1 + all.filter((other) => other > value).length);
}

/** What stands in bold: as it is shown, so that equal texts look equal. Nothing for a single row. */
export function bestText(rows: readonly Pick<Row, 'means'>[], column: Column): string | undefined {
  const values = rows.flatMap((row) => valueOf(row, column) ?? []);
  if (rows.length < 2 || values.length === 0 || !column.better) return undefined;
  return format(column.better === 'higher' ? Math.max(...values) : Math.min(...values), column);
}

export type Direction = 'ascending' | 'descending';
/** How a column is sorted first: the best on top. */
export const firstDirection = ({ better }: Column): Direction => (better === 'higher' ? 'descending' : 'ascending');

/** What has no value comes last either way. */
export function sorted<T extends Pick<Row, 'means'>>(rows: readonly T[], by: Column, direction: Direction): T[] {
  const sign = direction === 'ascending' ? 1 : -1;
  return [...rows].sort((a, b) => {
    const [x, y] = [valueOf(a, by), valueOf(b, by)];
    if (x === undefined || y === undefined) return Number(x === undefined) - Number(y === undefined);
    return sign * (x - y);
  });
}
