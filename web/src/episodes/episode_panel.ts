/** An episode beside its building: text or dialogue, goal, reference path, an agent's walk. */
import { make } from '../elements/page.ts';
import { distancesFrom, lengthOf } from '../scan/distances.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { type MiniMap, type Outline, Player, type Viewer } from '../viewer/enfilade-viewer.ts';
import type { Episode, Goal, Part } from './episode.ts';
import { successDistance } from './navigation_errors.ts';
import { keptResults } from './results.ts';
import { endCounts } from './splits.ts';
import { EvenWalk, lengthOf as secondsOf, TraceWalk, wordAt } from './spoken_instruction.ts';

const indicesOf = (viewer: Viewer, ids: readonly string[] = []): number[] => ids.map((id) => viewpointIndex(viewer.scan, id));

/** How a walk ended, as the tables measure it. */
function verdict(viewer: Viewer, path: readonly number[], walk: readonly number[], judged: boolean): HTMLElement {
  const error = distancesFrom(viewer.scan, path.at(-1)!)[walk.at(-1)!]!;
  const what = judged ? 'the goal' : 'the end of the reference path';
  const away = Number.isFinite(error) ? `${error.toFixed(1)} m from ${what}` : `out of reach of ${what}`;
  const walked = `The agent walked ${lengthOf(viewer.scan, walk).toFixed(1)} m and stopped ${away}`;
  if (!judged) return make('p', { class: 'note' }, `${walked}.`);
  return make('p', { class: error < successDistance ? 'done' : 'problem' }, `${walked}: ${error < successDistance ? 'a success.' : 'no success.'}`);
}

/** "Hindi (India)", or the code where the browser has no name for it. */
function languageName(code: string): string {
  try {
    return new Intl.DisplayNames('en', { type: 'language' }).of(code) ?? code;
  } catch {
    return code; // no well-formed code
  }
}

const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** A dialogue as its turns; what comes after <TAR> is in the goal. */
function dialogue({ turns = [] }: Episode): HTMLElement {
  return make('ol', { class: 'said-turns' }, ...turns.map(({ role, message, nav_step }) =>
    make('li', { class: role === 'oracle' ? 'oracle' : 'navigator' },
      make('b', {}, capital(role)), nav_step > 0 ? make('span', { class: 'note' }, ` after ${nav_step} ${nav_step === 1 ? 'step' : 'steps'}`) : '',
      make('p', {}, message))));
}

function instruction({ instruction: text, language }: Episode): HTMLElement {
  const said = make('p', { class: 'instruction' }, text);
  if (!language) return said;
  said.lang = language;
  return make('div', {}, make('p', { class: 'note' }, `Language: ${languageName(language)}`), said);
}

/** The words with those that have been said marked, and a player of path and words. */
function recital(viewer: Viewer, { words = [], language, heading, trace, trace_problem }: Episode, path: readonly number[]): HTMLElement {
  const spans = words.map(({ word }) => make('span', {}, word));
  const text = make('p', { class: 'instruction spoken' }, ...spans.flatMap((span, k) => (k > 0 ? [' ', span] : [span])));
  if (language) text.lang = language;
  const walk = trace ? new TraceWalk(viewer.scan, trace, secondsOf(words)) : new EvenWalk(viewer.scan, path, secondsOf(words), heading);
  const player = new Player(viewer, walk, (seconds) => {
    const said = wordAt(words, seconds);
    spans.forEach((span, k) => span.classList.toggle('said', k === said));
  });
  player.element.setAttribute('aria-label', 'The path with its words');
  return make('div', {}, language ? make('p', { class: 'note' }, `Language: ${languageName(language)}`) : '', text, player.element,
    make('p', { class: 'note' }, trace ? 'Words as they were spoken, and where the speaker stood and looked meanwhile.'
      : 'Words as they were spoken. Where the speaker was meanwhile is not known here: the path is walked evenly.'),
    trace_problem ? make('p', { class: 'problem' }, capital(trace_problem) + '.') : '');
}

/** Pieces of the instruction; each goes to where it begins. */
function pieces(viewer: Viewer, parts: readonly Part[], path: readonly number[]): HTMLElement {
  return make('ol', { class: 'parts' }, ...parts.map(({ words, places }) => {
    const at = places ? path[places[0]] : undefined;
    if (at === undefined) return make('li', {}, words.join(' '));
    const button = make('button', { type: 'button', class: 'quiet' }, words.join(' '));
    button.addEventListener('click', () => void viewer.go(at));
    return make('li', {}, button);
  }));
}

/** The middle of a rim: where one looks to see the object. */
function middleOf(rim: readonly number[]): { heading: number; elevation: number } {
  let [x, y, z] = [0, 0, 0];
  for (let k = 0; k + 1 < rim.length; k += 2) {
    x += Math.sin(rim[k]!) * Math.cos(rim[k + 1]!);
    y += Math.cos(rim[k]!) * Math.cos(rim[k + 1]!);
    z += Math.sin(rim[k + 1]!);
  }
  return { heading: Math.atan2(x, y), elevation: Math.atan2(z, Math.hypot(x, y)) };
}

const viewpoints = (count: number): string => `${count} ${count === 1 ? 'viewpoint' : 'viewpoints'}`;

function goalText({ kind, name, object, viewpoints: places = [] }: Goal): string {
  const count = viewpoints(places.length);
  switch (kind) {
    case 'object': return `Goal: to find ${name ? `the ${name}` : 'an object'} (object ${object}), seen from ${count}`;
    case 'boxes': return `Goal: to find ${name ? `the ${name}` : 'an object'}, shown at ${count}`;
    case 'region': return `Goal: ${name ? `the region of the ${name}` : 'a region'}, ${count}`;
    case 'turning_point': return 'Goal: to go to a turning point, to say where it is, and to come back';
    default: return '';
  }
}

/** What is to be found, with a button that looks at it from the end of the path or the first place that sees it. */
function goalPart(viewer: Viewer, goal: Goal, path: readonly number[]): HTMLElement | undefined {
  const text = goalText(goal);
  if (!text) return undefined;
  const part = make('div', { class: 'goal-part' }, make('p', {}, text));
  const outlines = outlinesOf(viewer, goal);
  const shown = outlines.find(({ viewpoint }) => viewpoint === path.at(-1)) ?? outlines[0];
  const turn = goal.kind === 'turning_point' ? indicesOf(viewer, goal.viewpoints)[0] : undefined;
  if (!shown && turn === undefined) return part;
  const look = make('button', { type: 'button' }, shown ? 'Look at it' : 'Go there');
  look.addEventListener('click', () => void viewer.jump(shown ? { viewpoint: shown.viewpoint, ...middleOf(shown.rim) } : { viewpoint: turn! }));
  part.append(look);
  return part;
}

const outlinesOf = (viewer: Viewer, { outlines = [] }: Goal): Outline[] =>
  outlines.map(({ viewpoint, label, rim }) => ({ viewpoint: viewpointIndex(viewer.scan, viewpoint), label, rim }))
    .filter(({ viewpoint }) => viewpoint >= 0);

function says(viewer: Viewer, episode: Episode, path: readonly number[]): HTMLElement[] {
  const { turns, words, parts, fields } = episode;
  const timed = words !== undefined && path.length > 0 && secondsOf(words) > 0;
  const parted = Object.entries(fields ?? {}).filter(([, value]) => value);
  return [
    turns ? dialogue(episode) : timed ? recital(viewer, episode, path) : instruction(episode),
    ...(parts ? [pieces(viewer, parts, path)] : []),
    ...(parted.length > 0 ? [make('dl', { class: 'fields' }, ...parted.flatMap(([name, value]) =>
      [make('dt', {}, name === 'obj_name' ? 'Object' : capital(name.replaceAll('_', ' '))), make('dd', {}, value)]))] : []),
  ];
}

/** Shows an episode in the panel, the map and the view. @param key of its split */
export async function showEpisode(panel: HTMLElement, viewer: Viewer, map: MiniMap, episode: Episode, key: string): Promise<void> {
  const path = indicesOf(viewer, episode.path);
  const results = await keptResults(key);
  const walk = indicesOf(viewer, results?.get(episode.instruction_id)?.viewpoints);
  if (walk.includes(-1)) throw new Error(`${episode.instruction_id}: the results are of another building`);
  const { goal } = episode;
  const seen = indicesOf(viewer, goal?.viewpoints).filter((v) => v >= 0);
  viewer.setPath(path, seen);
  viewer.setOutlines(goal ? outlinesOf(viewer, goal) : []);
  map.setPath(path, walk, seen);
  panel.append(...says(viewer, episode, path));
  const found = goal && goalPart(viewer, goal, path);
  if (found) panel.append(found);
  if (path.length === 0) panel.append(make('p', { class: 'note' }, 'The goal of this one is hidden.'));
  if (path.length > 0) {
    panel.append(make('h2', {}, 'Reference path'), new Player(viewer, path).element,
      make('p', { class: 'note' }, `${viewpoints(path.length)}, ${(episode.distance ?? lengthOf(viewer.scan, path)).toFixed(1)} m`));
  }
  if (walk.length > 0) {
    const player = new Player(viewer, walk);
    player.element.setAttribute('aria-label', "Fly-through of the agent's path");
    panel.append(make('h2', {}, "The agent's path"), player.element);
    if (path.length > 0) panel.append(verdict(viewer, path, walk, endCounts(key)));
  }
}
