/** Episodes of a split as the filters list them: by the server, or in the browser where a results file or an order decides. */
import type { Api } from '../server/api.ts';
import type { Episode } from './episode.ts';
import { type Filters, isServersList, perPage } from './filters.ts';
import { errorsOf, successDistance } from './navigation_errors.ts';
import type { Results } from './results.ts';
import { episodesOf, isOnFloor } from './splits.ts';

interface EpisodeList {
  readonly matching: number;
  readonly episodes: readonly Episode[];
}
/** A whole split in the browser, with a results file's errors. */
interface Whole {
  readonly split: string;
  readonly results: Results | undefined;
  readonly episodes: readonly Episode[];
  readonly errors: ReadonlyMap<string, number>;
}
/** Where an episode stands in a list, and the ids beside it. */
export type Place = Pick<Episode, 'number' | 'of' | 'previous' | 'next'>;

/** A continuous episode, as far as lists show it. */
interface FloorEpisode {
  readonly id: string;
  readonly trajectory: string;
  readonly scan: string;
  readonly heading: number;
  readonly instruction: string;
  readonly language?: string;
  readonly path?: unknown;
  readonly distance?: number;
}

const asListed = ({ id, trajectory, path, ...rest }: FloorEpisode): Episode =>
  ({ ...rest, instruction_id: id, path_id: Number(trajectory), start: '', ...(path !== undefined && { path: [] }) });

/** A page of the server's list. @param key of the split */
async function askFor(api: Api, key: string, query: Readonly<Record<string, string>>): Promise<EpisodeList> {
  if (!isOnFloor(key)) return api.call<EpisodeList>(episodesOf(key, query));
  const { matching, episodes } = await api.call<{ matching: number; episodes: FloorEpisode[] }>(episodesOf(key, query));
  return { matching, episodes: episodes.map(asListed) };
}

/** All of a split, page by page. @param key of the split */
export async function allEpisodes(api: Api, key: string): Promise<Episode[]> {
  const all: Episode[] = [];
  for (;;) {
    const { matching, episodes } = await askFor(api, key, { offset: String(all.length), limit: '500' });
    all.push(...episodes);
    if (all.length >= matching || episodes.length === 0) return all;
  }
}

/** Episodes without the number to sort by come last. */
export function inOrder(episodes: readonly Episode[], errors: Whole['errors'], order: Filters['order']): Episode[] {
  const list = [...episodes];
  if (order === 'file') return list;
  const value = (episode: Episode) => (order.startsWith('error') ? errors.get(episode.instruction_id) : episode.distance);
  const sign = order === 'error-up' || order === 'shortest' ? 1 : -1;
  return list.sort((a, b) => {
    const [x, y] = [value(a), value(b)];
    if (x === undefined || y === undefined) return Number(x === undefined) - Number(y === undefined);
    return x === y ? 0 : sign * (x - y); // infinite ones too
  });
}

function matches(episode: Episode, { results, errors }: Pick<Whole, 'results' | 'errors'>, { scan, words, outcome }: Filters): boolean {
  if (scan && episode.scan !== scan) return false;
  if (!episode.instruction.toLowerCase().includes(words.toLowerCase())) return false;
  const error = errors.get(episode.instruction_id);
  if (outcome === 'failed') return error !== undefined && error >= successDistance;
  if (outcome === 'reached') return error !== undefined && error < successDistance;
  if (outcome === 'missing') return results !== undefined && !results.has(episode.instruction_id);
  return true;
}

/** The place of an id in a list; nothing if it is not there. */
export function placeIn(list: readonly Pick<Episode, 'instruction_id'>[], id: string): Place | undefined {
  const k = list.findIndex(({ instruction_id }) => instruction_id === id);
  if (k < 0) return undefined;
  const [before, after] = [list[k - 1], list[k + 1]];
  return { number: k + 1, of: list.length, ...(before && { previous: before.instruction_id }), ...(after && { next: after.instruction_id }) };
}

export class Listing {
  private readonly api: Api;
  private whole: Whole | undefined;
  /** How often forget() was called: what was asked for before is not kept. */
  private forgotten = 0;

  constructor(api: Api) {
    this.api = api;
  }

  /** The error of an episode's trajectory, once find() has needed it. */
  error(id: string): number | undefined {
    return this.whole?.errors.get(id);
  }

  /** After the results file changed. */
  forget(): void {
    this.whole = undefined;
    ++this.forgotten;
  }

  /** The page's episodes, and how many match in all. @param results of the split, where there are some */
  async find(filters: Filters, results: Results | undefined): Promise<EpisodeList> {
    const { split, scan, words, offset } = filters;
    if (!results && isServersList(filters)) return askFor(this.api, split, { q: words, scan, offset: String(offset), limit: String(perPage) });
    const found = await this.all(filters, results);
    return { matching: found.length, episodes: found.slice(offset, offset + perPage) };
  }

  /** The neighbours of an episode in the whole list. */
  async place(filters: Filters, results: Results | undefined, id: string): Promise<Place | undefined> {
    return placeIn(await this.all(filters, results), id);
  }

  private async all(filters: Filters, results: Results | undefined): Promise<Episode[]> {
    const whole = await this.load(filters.split, results);
    return inOrder(whole.episodes.filter((one) => matches(one, whole, filters)), whole.errors, filters.order);
  }

  private async load(split: string, results: Results | undefined): Promise<Whole> {
    if (this.whole?.split === split) return this.whole;
    const { forgotten } = this;
    const episodes = await allEpisodes(this.api, split);
    const whole = { split, results, episodes, errors: results ? await errorsOf(this.api, episodes, results) : new Map<string, number>() };
    if (forgotten === this.forgotten) this.whole = whole;
    return whole;
  }
}
