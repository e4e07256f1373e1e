/** What the episodes page shows, as its address has it: Back, reload and a sent link show the same. */

export type Order = 'file' | 'error-down' | 'error-up' | 'longest' | 'shortest';
export const orders: readonly (readonly [Order, string])[] = [
  ['file', 'as in the file'], ['error-down', 'navigation error, largest first'], ['error-up', 'navigation error, smallest first'],
  ['longest', 'length, longest first'], ['shortest', 'length, shortest first'],
];
export type Outcome = 'all' | 'failed' | 'reached' | 'missing';
export const outcomes: readonly (readonly [Outcome, string])[] = [
  ['all', 'all'], ['failed', 'no success'], ['reached', 'success'], ['missing', 'not in the results'],
];

export interface Filters {
  readonly split: string;
  readonly scan: string;
  readonly words: string;
  readonly order: Order;
  readonly outcome: Outcome;
  readonly offset: number;
}

const one = <T extends string>(list: readonly (readonly [T, string])[], text: string | null): T =>
  list.find(([name]) => name === text)?.[0] ?? list[0]![0];

/** @param splits those that there are; the first is shown if the address names none of them */
export function parseFilters(search: string, splits: readonly string[]): Filters {
  const query = new URLSearchParams(search);
  const offset = Number(query.get('offset') ?? 0);
  return {
    split: splits.find((name) => name === query.get('split')) ?? splits[0] ?? '',
    scan: query.get('scan') ?? '',
    words: query.get('q') ?? '',
    order: one(orders, query.get('sort')),
    outcome: one(outcomes, query.get('outcome')),
    offset: Number.isSafeInteger(offset) && offset > 0 ? offset : 0,
  };
}

/** Its inverse: only what is not as it would be anyway. */
export function formatFilters({ split, scan, words, order, outcome, offset }: Filters): string {
  const query = new URLSearchParams({ split });
  if (scan) query.set('scan', scan);
  if (words) query.set('q', words);
  if (order !== 'file') query.set('sort', order);
  if (outcome !== 'all') query.set('outcome', outcome);
  if (offset > 0) query.set('offset', String(offset));
  return `?${query}`;
}
