/** Any instruction that a visitor can follow: pictures are there, and everybody may see the goal. */
import { endCounts, episodesOf, parseKey, type Split, splitKey } from './splits.ts';

/** What the server has, as its lists say it. */
export interface Offer {
  /** All benchmarks'. */
  readonly splits: readonly Split[];
  readonly scans: readonly { readonly scan: string; readonly pictures: boolean }[];
}
/** Only of these, where they are given. */
interface Wish {
  readonly scan?: string | undefined;
  /** splitKey() */
  readonly split?: string | undefined;
}
interface NamedEpisode {
  /** splitKey() */
  readonly split: string;
  readonly id: string;
}

interface Page { readonly matching: number; readonly episodes: readonly { readonly instruction_id: string }[] }
type Ask = (path: string) => Promise<Page>;
/** From 0 to below 1. */
type Random = () => number;

/** A copy in any order; all are equally likely. */
function shuffled<T>(list: readonly T[], random: Random): T[] {
  const all = [...list];
  for (let k = all.length - 1; k > 0; --k) {
    const other = Math.floor(random() * (k + 1));
    [all[k], all[other]] = [all[other]!, all[k]!];
  }
  return all;
}

async function anyOf(ask: Ask, split: string, scan: string, random: Random): Promise<NamedEpisode | undefined> {
  const page = (offset: number) => ask(episodesOf(split, { scan, limit: '1', offset: String(offset) }));
  const first = await page(0);
  if (first.matching === 0) return undefined;
  const { episodes: [episode] } = await page(Math.floor(random() * first.matching));
  return episode && { split, id: episode.instruction_id };
}

/**
 * Splits in any order, R2R's first; then buildings in any order. Nothing if no building with pictures has an open instruction.
 * @param ask of the server's API
 */
export async function anyEpisode(
  ask: Ask, { splits, scans }: Offer, wish: Wish = {}, random: Random = Math.random,
): Promise<NamedEpisode | undefined> {
  const keys = splits.filter(({ goals_hidden, instructions }) => !goals_hidden && instructions > 0).map(splitKey)
    .filter((key) => (wish.split === undefined ? endCounts(key) : key === wish.split));
  const isFirst = (key: string) => parseKey(key).task === 'r2r';
  const inOrder = [...shuffled(keys.filter(isFirst), random), ...shuffled(keys.filter((key) => !isFirst(key)), random)];
  const pictured = scans.filter(({ scan, pictures }) => pictures && (wish.scan === undefined || scan === wish.scan));
  for (const split of inOrder) {
    for (const { scan } of shuffled(pictured, random)) {
      const found = await anyOf(ask, split, scan, random);
      if (found) return found;
    }
  }
  return undefined;
}
