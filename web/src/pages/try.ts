/**
 * Following an instruction as agents do, for visitors: nothing is kept. `/try?split=S&id=I`; without an id any instruction, of the split or of
 * the building that `?scan=` names.
 */
import { lacksGraphics } from '../elements/graphics.ts';
import { noBuilding, showInstead } from '../elements/instead.ts';
import { addHeader, byId, empty, make, run, type Served } from '../elements/page.ts';
import { anyEpisode, type Offer } from '../episodes/any_episode.ts';
import { type Episode, shownText } from '../episodes/episode.ts';
import { noEpisode } from '../episodes/find_episode.ts';
import { judge } from '../episodes/outcome.ts';
import { outcomeHeading, outcomePart } from '../episodes/outcome_part.ts';
import { episodePage, episodesOf, isOnFloor, isPlayable, parseKey, type SplitList } from '../episodes/splits.ts';
import { api } from '../server/api.ts';
import { keyHelp } from '../viewer/controls.ts';
import { agentRules, Viewer } from '../viewer/enfilade-viewer.ts';
import { turnHint } from '../viewer/turn_hint.ts';
import { formatLink } from '../viewer/deep_link.ts';

declare global {
  interface Window {
    /** For tests, and for the curious at the console. */
    walker?: { viewer: Viewer };
  }
}

interface Chosen {
  /** splitKey() */
  readonly split: string;
  readonly episode: Episode;
}
interface Asked {
  readonly split: string | undefined;
  readonly id: string | undefined;
  readonly scan: string | undefined;
}
type Offered = Offer & Served;

const link = (href: string, text: string): HTMLElement => make('a', { href, class: 'button' }, text);
const anyOther = (): HTMLElement => link('/try', 'Any instruction');
const tryAddress = (parts: Readonly<Record<string, string | undefined>>): string =>
  `/try?${new URLSearchParams(Object.entries(parts).filter((one): one is [string, string] => one[1] !== undefined))}`;

/** The way to /play; none where it has no tool for the answer. */
function playLink(split: string, episode: string, text: string): HTMLElement[] {
  const { task, split: name } = parseKey(split);
  return isPlayable(task) ? [link(`/play?${new URLSearchParams({ task, split: name, episode })}`, text)] : [];
}

/** The episode of an id, with its goal. What stands on the page if there is none, or if its goal is hidden. */
async function named(split: string, id: string): Promise<Chosen | HTMLElement> {
  if (isOnFloor(split)) {
    return empty('A continuous episode', 'Agents move over the floor here, not between viewpoints.',
      link(episodePage(split, id), 'Open it'), anyOther());
  }
  const { episodes: [episode] } = await api.call<{ episodes: Episode[] }>(episodesOf(split, { id }));
  if (!episode) return noEpisode(split, id, anyOther());
  if (episode.path) return { split, episode };
  return empty('The goal is hidden', `Split ${split} keeps its goals secret, so nothing could be said of where you stop.`,
    ...playLink(split, id, 'Play it without an outcome'), anyOther());
}

function nothing({ scan, split }: Asked, { scans }: Offered): HTMLElement {
  const buildings = link('/', 'Buildings');
  if (scan !== undefined) {
    const found = scans.find((one) => one.scan === scan);
    if (!found) return noBuilding(scan);
    return empty('No instruction here', `${scan} has no instruction whose goal is open, with pictures.`,
      ...(found.pictures ? [link(`/view${formatLink({ scan })}`, `Explore ${scan}`)] : [buildings]), anyOther());
  }
  if (split !== undefined) return empty('No instruction here', `Split ${split} has no instruction whose goal is open, with pictures.`, anyOther());
  return empty('No instruction to follow', 'This data set has no episode with pictures and an open goal.', buildings);
}

/** The episode that the address names, or any that fits it; else what stands on the page. */
async function choose(asked: Asked): Promise<Chosen | HTMLElement> {
  const { split, id, scan } = asked;
  if (split !== undefined && id !== undefined) return named(split, id);
  const [{ splits }, offered] = await Promise.all([api.call<SplitList>('splits?task=all'), api.call<Offered>('scans')]);
  addHeader(offered);
  const found = await anyEpisode((path) => api.call(path), { ...offered, splits }, { scan, split });
  return found ? named(found.split, found.id) : nothing(asked, { ...offered, splits });
}

/** What came of it, and what to do next. */
function ending(viewer: Viewer, { split, episode }: Chosen, walk: readonly number[], next: string): HTMLElement {
  const outcome = judge(viewer.scan, episode, walk)!;
  const part = outcomePart(api, viewer, outcome);
  part.prepend(outcomeHeading(outcome));
  part.append(make('p', { class: 'buttons' }, make('a', { href: next, class: 'button main' }, 'Next instruction'),
    link(episodePage(split, episode.instruction_id), 'Show the reference path'),
    ...playLink(split, episode.instruction_id, 'Play it as a language model')));
  return part;
}

run(async () => {
  if (lacksGraphics()) return;
  const main = byId('main');
  const query = new URLSearchParams(location.search);
  const [split, id, scan] = ['split', 'id', 'scan'].map((name) => query.get(name) || undefined);
  const chosen = await choose({ split, id, scan });
  if (chosen instanceof HTMLElement) return showInstead('Follow an instruction', chosen);
  const { episode } = chosen;
  history.replaceState(null, '', tryAddress({ split: chosen.split, id: episode.instruction_id, scan })); // reload is the same one
  const view = make('div', { class: 'agent' });
  const stage = make('div', { class: 'view stage' }, view);
  const side = make('aside', { class: 'side', 'aria-label': 'Your task' });
  main.append(stage, side);
  const viewer = await Viewer.open(view, { scan: episode.scan, rules: agentRules, viewpoint: episode.start, heading: episode.heading, elevation: 0 });
  addHeader(viewer.scan);
  const hint = turnHint(viewer);
  stage.append(hint);
  const walk = [viewer.pose.viewpoint];
  viewer.onChange(({ viewpoint }) => { if (viewpoint !== walk.at(-1)) walk.push(viewpoint); });
  const stop = make('button', { type: 'button', class: 'main' }, 'Stop here');
  const said = make('p', { class: 'instruction', ...(episode.language && { lang: episode.language }) }, shownText(episode.instruction, episode.task));
  const panel = make('div', { class: 'panel' }, make('h1', {}, 'Follow the instruction'), said,
    make('p', {}, stop), make('p', { class: 'note' },
      'You have the view of an agent. Drag to look around, and click a ring on the floor to go there. Stop where you think the goal is. ',
      make('span', { class: 'keys' }, keyHelp(viewer))));
  stop.addEventListener('click', () => {
    viewer.confine([]); // the episode is over: one can still look around
    hint.remove();
    const result = ending(viewer, chosen, walk, scan === undefined ? '/try' : tryAddress({ scan }));
    stop.parentElement!.replaceWith(result);
    result.querySelector('h2')!.focus();
  });
  side.append(panel);
  window.walker = { viewer };
});
