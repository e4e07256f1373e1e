/** The episode that an address names, `?split=S&id=I&submission=3`, and the filters of the list in which it was chosen. */
import { empty, make } from '../elements/page.ts';
import type { Api } from '../server/api.ts';
import type { Episode } from './episode.ts';
import { type Filters, formatFilters, narrowing, parseFilters, perPage } from './filters.ts';
import { episodePage, episodesOf } from './splits.ts';

export interface FoundEpisode {
  readonly episode: Episode;
  /** splitKey() */
  readonly key: string;
  /** The split's, for people: "REVERIE val_unseen". */
  readonly title: string;
  readonly filters: Filters;
  /** Whose trajectory is shown: `&submission=3`. */
  readonly submission?: string;
}

/** What stands on a page where a split has no such episode, with a way back. */
export const noEpisode = (key: string, id: string, ...more: HTMLElement[]): HTMLElement =>
  empty('No such episode', `Split ${key} has no episode "${id}".`,
    make('a', { href: `/episodes?${new URLSearchParams({ split: key })}`, class: 'button' }, `Episodes of ${key}`), ...more);

/** Nothing where the address names none; what stands on the page where there is none of that id. */
export async function findEpisode(api: Api, search: string): Promise<FoundEpisode | HTMLElement | undefined> {
  const query = new URLSearchParams(search);
  const [key, id] = [query.get('split'), query.get('id')];
  if (!key || !id) return undefined;
  const filters = parseFilters(search, [key]);
  const { split, title, episodes: [episode] } = await api.call<{ split: string; title: string; episodes: Episode[] }>(
    episodesOf(key, { id, scan: filters.scan, q: filters.words }));
  const submission = query.get('submission');
  return episode ? { episode, key, title: `${title} ${split}`, filters, ...(submission && { submission }) } : noEpisode(key, id);
}

/** An episode of the same list, with the same submission. */
export const neighbourPage = ({ key, filters, submission }: Omit<FoundEpisode, 'episode' | 'title'>, id: string): string =>
  episodePage(key, id, { ...narrowing(filters), ...(submission && { submission }) });

/** The page of the list that has an episode. @param number its place there, from 1, as far as it is known */
export const listPage = ({ filters }: Pick<FoundEpisode, 'filters'>, number = 1): string =>
  `/episodes${formatFilters({ ...filters, offset: Math.floor((number - 1) / perPage) * perPage })}`;
