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

/** @param splits keys of those that there are; the first is shown if the address names none of them */
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

/** How many episodes the page shows at once. */
export const perPage = 50;

/** Names and values in the address, but of the split and the offset: only what is not as it would be anyway. */
export function narrowing({ scan, words, order, outcome }: Omit<Filters, 'split' | 'offset'>): Record<string, string> {
  return {
    ...(scan && { scan }), ...(words && { q: words }), ...(order !== 'file' && { sort: order }), ...(outcome !== 'all' && { outcome }),
  };
}

/** Whether the server makes that list by itself, so that nothing need be known of the whole split. */
export const isServersList = ({ order, outcome }: Pick<Filters, 'order' | 'outcome'>): boolean => order === 'file' && outcome === 'all';

/** The inverse of parseFilters(). */
export function formatFilters(filters: Filters): string {
  const { split, offset } = filters;
  return `?${new URLSearchParams({ split, ...narrowing(filters), ...(offset > 0 && { offset: String(offset) }) })}`;
}
