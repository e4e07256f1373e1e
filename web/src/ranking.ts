/** The leaderboard's rows: columns, places, orders and best values. */

export interface Mean { readonly mean: number | null; readonly low?: number | null; readonly high?: number | null }
export interface Row {
  readonly id: number;
  readonly team: string;
  readonly method: string;
  readonly created: string;
  readonly paper?: string;
  readonly code?: string;
  readonly means: Readonly<Record<string, Mean>>;
}

/** A metric. Its numbers are shown times `factor`, with `digits` after the point. */
export interface Column {
  /** As the server calls it. */
  readonly name: string;
  readonly short: string;
  readonly title: string;
  readonly unit: 'm' | '%';
  /** The better values; none where longer is neither better nor worse. */
  readonly better?: 'higher' | 'lower';
}

export const columns: readonly Column[] = [
  { name: 'spl', short: 'SPL', title: 'Success weighted by path length', unit: '%', better: 'higher' },
  { name: 'success', short: 'SR', title: 'Success rate', unit: '%', better: 'higher' },
  { name: 'oracle_success', short: 'OSR', title: 'Oracle success rate', unit: '%', better: 'higher' },
  { name: 'nav_error', short: 'NE', title: 'Navigation error', unit: 'm', better: 'lower' },
  { name: 'ndtw_collapsed', short: 'nDTW', title: 'Normalised dynamic time warping', unit: '%', better: 'higher' },
  { name: 'sdtw_collapsed', short: 'sDTW', title: 'Success weighted by nDTW', unit: '%', better: 'higher' },
  { name: 'cls', short: 'CLS', title: 'Coverage weighted by length score', unit: '%', better: 'higher' },
  { name: 'trajectory_length', short: 'TL', title: 'Trajectory length', unit: 'm' },
];

/** In the column's unit; nothing where it is not shown or not finite. */
export const valueOf = (row: Row, { name, unit }: Column): number | undefined => {
  const mean = row.means[name]?.mean;
  return mean === undefined || mean === null ? undefined : mean * (unit === '%' ? 100 : 1);
};

export const format = (value: number | undefined, { unit }: Column): string =>
  (value === undefined ? '–' : value.toFixed(unit === '%' ? 1 : 2));

/** 1 for the best; rows that show the same have the same place. */
export function places(rows: readonly Row[], by: Column): readonly number[] {
  const all = rows.map((row) => valueOf(row, by) ?? -Infinity);
  return all.map((value) => 1 + all.filter((other) => other > value).length);
}

/** What stands in bold: as it is shown, so that equal texts look equal. Nothing for a single row. */
export function bestText(rows: readonly Row[], column: Column): string | undefined {
  const values = rows.flatMap((row) => valueOf(row, column) ?? []);
  if (rows.length < 2 || values.length === 0 || !column.better) return undefined;
  return format(column.better === 'higher' ? Math.max(...values) : Math.min(...values), column);
}

export type Direction = 'ascending' | 'descending';
/** How a column is sorted first: the best on top. */
export const firstDirection = ({ better }: Column): Direction => (better === 'higher' ? 'descending' : 'ascending');

/** What has no value comes last either way. */
export function sorted<T extends Row>(rows: readonly T[], by: Column, direction: Direction): T[] {
  const sign = direction === 'ascending' ? 1 : -1;
  return [...rows].sort((a, b) => {
    const [x, y] = [valueOf(a, by), valueOf(b, by)];
    if (x === undefined || y === undefined) return Number(x === undefined) - Number(y === undefined);
    return sign * (x - y);
  });
}
