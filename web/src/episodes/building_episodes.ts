/** The first episodes of a building, for its page: with ways to all of them, and to following one. */
import { counted, make } from '../elements/page.ts';
import type { Api } from '../server/api.ts';
import { type Episode, shownText } from './episode.ts';
import { episodePage, episodesOf, offeredBenchmarks, parseKey, type SplitList } from './splits.ts';

const shown = 3;
/** One request each: most buildings are in one of the first. */
const mostAsked = 8;

interface Found {
  readonly key: string;
  /** "R2R val_unseen" */
  readonly title: string;
  readonly matching: number;
  readonly episodes: readonly Episode[];
}

/** The first split, in the order in which pages offer them, that has episodes of the building with goals for all to see. */
export async function firstEpisodes(api: Pick<Api, 'call'>, scan: string): Promise<Found | undefined> {
  const { splits } = await api.call<SplitList>('splits?task=all');
  const open = offeredBenchmarks({ splits: splits.filter(({ goals_hidden }) => !goals_hidden), continuous: [] })
    .flatMap(({ title, splits: own }) => own.map(({ key, split }) => ({ key, title: `${title} ${split}` })));
  for (const one of open.slice(0, mostAsked)) {
    const { matching, episodes } = await api.call<Pick<Found, 'matching' | 'episodes'>>(episodesOf(one.key, { scan, limit: String(shown) }));
    if (matching > 0) return { ...one, matching, episodes };
  }
  return undefined;
}

/** Nothing where the building has no such episode. */
export async function buildingEpisodes(api: Api, scan: string): Promise<HTMLElement | undefined> {
  const found = await firstEpisodes(api, scan);
  if (!found) return undefined;
  const { key, title, matching, episodes } = found;
  return make('section', { 'aria-label': 'Episodes here' }, make('h2', {}, 'Episodes here'),
    make('p', { class: 'buttons' }, make('a', { class: 'button', href: `/try?${new URLSearchParams({ scan })}` }, 'Follow an instruction here')),
    make('ul', { class: 'building-episodes' }, ...episodes.map(({ instruction_id: id, instruction, language }) => {
      const text = make('p', {}, shownText(instruction, parseKey(key).task));
      if (language) text.lang = language;
      return make('li', {}, make('a', { href: episodePage(key, id) }, id), text);
    })),
    make('p', {}, make('a', { href: `/episodes?${new URLSearchParams({ split: key, scan })}` }, `${counted(matching, 'episode')} of ${title} here`)));
}
