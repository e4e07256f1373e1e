/** Around an episode in the panel: what it is, its neighbours, the other instructions of its path, and what else can be done with it. */
import { counted, crumbs, make } from '../elements/page.ts';
import type { Api } from '../server/api.ts';
import { type Episode, languageName, shownText } from './episode.ts';
import { isServersList } from './filters.ts';
import { type FoundEpisode, listPage, neighbourPage } from './find_episode.ts';
import type { Place } from './listing.ts';
import { isPlayable, parseKey, splitKey } from './splits.ts';

/** Previous, next, and the place between. */
function neighbours(found: FoundEpisode, { number, of, previous, next }: Place): HTMLElement {
  const link = (id: string | undefined, text: string, rel: string) =>
    (id === undefined ? [] : [make('a', { class: 'button', rel, href: neighbourPage(found, id) }, text)]);
  return make('nav', { class: 'pages', 'aria-label': 'Episodes of the list' }, ...link(previous, 'Previous', 'prev'),
    ...(number !== undefined && of !== undefined ? [make('span', {}, `${number.toLocaleString('en-US')} of ${of.toLocaleString('en-US')}`)] : []),
    ...link(next, 'Next', 'next'));
}

/** The way back to the list, id, split, building, neighbours. */
export class EpisodeHead {
  readonly element: HTMLElement;
  private readonly found: FoundEpisode;

  constructor(found: FoundEpisode) {
    this.found = found;
    this.element = make('div', { class: 'episode-head' });
    this.show(isServersList(found.filters) ? found.episode : {}); // the server's neighbours are those of its own list
  }

  /** @param place in the list, where the server does not know it */
  show(place: Place): void {
    const { episode: { instruction_id: id, scan }, title } = this.found;
    this.element.replaceChildren(crumbs([[listPage(this.found, place.number), `Episodes of ${title}`]], id),
      make('h1', {}, `Episode ${id}`), make('p', { class: 'note' }, `${title}, building ${scan}`), neighbours(this.found, place));
  }
}

/** Nothing if the path has no other. More than a few can be folded. */
export function otherInstructions(found: FoundEpisode): HTMLElement | undefined {
  const { instruction_id: own, instructions = [], task } = found.episode;
  const others = instructions.filter(({ instruction_id }) => instruction_id !== own);
  if (others.length === 0) return undefined;
  const summary = make('summary', {}, `${counted(others.length, 'other instruction')} of this path`);
  const list = make('ul', {}, ...others.map(({ instruction_id: id, instruction, language }) => {
    const text = make('p', { class: 'shown' }, shownText(instruction, task));
    if (language) text.lang = language;
    return make('li', {}, make('a', { href: neighbourPage(found, id) }, id),
      ...(language ? [' ', make('span', { class: 'badge' }, languageName(language))] : []), text);
  }));
  const box = make('details', { class: 'other-instructions' }, summary, list);
  box.open = others.length <= 4;
  return box;
}

/** Following it, and playing it as a model does. @param pictured the building has pictures */
export function episodeLinks({ episode: { instruction_id: id, path }, key }: FoundEpisode, pictured: boolean): HTMLElement {
  const { task, split } = parseKey(key);
  const link = (page: string, parts: Record<string, string>, text: string) =>
    make('a', { class: 'button', href: `${page}?${new URLSearchParams(parts)}` }, text);
  return make('p', { class: 'buttons' },
    ...(path && pictured ? [link('/try', { split: key, id }, 'Follow it yourself')] : []),
    ...(isPlayable(task) ? [link('/play', { task, split, episode: id }, 'Play it as a language model')] : []));
}

interface ListedRun { readonly run: string; readonly task: string | null; readonly split: string | null; readonly model: string | null }

/** Runs that have the episode, each with a link to its replay; nothing if there are none. */
export async function runLinks(api: Api, { instruction_id: episode }: Episode, key: string): Promise<HTMLElement | undefined> {
  const { runs } = await api.call<{ runs: ListedRun[] }>(`runs?${new URLSearchParams({ episode })}`);
  const own = runs.filter(({ task, split }) => task !== null && split !== null && splitKey({ task, split }) === key);
  if (own.length === 0) return undefined;
  const items = own.map(({ run, model }) => make('li', {}, make('a', { href: `/replay?${new URLSearchParams({ run, episode })}` }, run),
    ...(model ? [make('span', { class: 'note' }, ` ${model}`)] : [])));
  return make('div', {}, make('h2', {}, 'Replay of runs'), make('ul', { class: 'episode-runs' }, ...items));
}
