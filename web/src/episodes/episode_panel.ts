/** An episode beside its building: text or dialogue, goal, reference path, an agent's walk. */
import { counted, make, problems } from '../elements/page.ts';
import { lengthOf } from '../scan/distances.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { api, passSilence } from '../server/api.ts';
import { type MiniMap, type Outline, Player, type Viewer } from '../viewer/enfilade-viewer.ts';
import { type Episode, type Goal, languageName, shownText } from './episode.ts';
import { EpisodeHead, episodeLinks, otherInstructions, runLinks } from './episode_head.ts';
import { isServersList } from './filters.ts';
import { type FoundEpisode, neighbourPage } from './find_episode.ts';
import { Listing } from './listing.ts';
import { judge, outcomeText, ruleText } from './outcome.ts';
import { PartList } from './part_list.ts';
import { keptResults, type Results } from './results.ts';
import { EvenWalk, lengthOf as secondsOf, TraceWalk, wordAt } from './spoken_instruction.ts';
import { submissionLinks, submittedWalk } from './submitted.ts';
import './episode.css';

const indicesOf = (viewer: Viewer, ids: readonly string[] = []): number[] => ids.map((id) => viewpointIndex(viewer.scan, id));

/** The outcome of an agent's trajectory, as its benchmark has it. */
function verdict(viewer: Viewer, episode: Episode, walk: readonly number[]): HTMLElement[] {
  const outcome = judge(viewer.scan, episode, walk);
  if (!outcome) return [];
  const text = outcomeText(outcome, 'The agent').replace(/\.$/, '');
  return [make('p', { class: outcome.success ? 'done' : 'problem' }, `${text}: ${outcome.success ? 'a success.' : 'no success.'}`),
    make('p', { class: 'note' }, ruleText(outcome))];
}

const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** A dialogue as its turns; what comes after <TAR> is in the goal. */
function dialogue({ turns = [] }: Episode): HTMLElement {
  return make('ol', { class: 'said-turns' }, ...turns.map(({ role, message, nav_step }) =>
    make('li', { class: role === 'oracle' ? 'oracle' : 'navigator' },
      make('b', {}, capital(role)), nav_step > 0 ? make('span', { class: 'note' }, ` after ${nav_step} ${nav_step === 1 ? 'step' : 'steps'}`) : '',
      make('p', {}, message))));
}

function instruction({ instruction: text, language, task }: Episode): HTMLElement {
  const said = make('p', { class: 'instruction' }, shownText(text, task));
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

function goalText({ kind, name, object, viewpoints: places = [] }: Goal): string {
  const count = counted(places.length, 'viewpoint');
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
  look.addEventListener('click', () => {
    viewer.jump(shown ? { viewpoint: shown.viewpoint, ...middleOf(shown.rim) } : { viewpoint: turn! }).catch(passSilence);
  });
  part.append(look);
  return part;
}

const outlinesOf = (viewer: Viewer, { outlines = [] }: Goal): Outline[] =>
  outlines.map(({ viewpoint, label, rim }) => ({ viewpoint: viewpointIndex(viewer.scan, viewpoint), label, rim }))
    .filter(({ viewpoint }) => viewpoint >= 0);

function says(viewer: Viewer, episode: Episode, path: readonly number[]): HTMLElement[] {
  const { turns, words, fields } = episode;
  const timed = words !== undefined && path.length > 0 && secondsOf(words) > 0;
  const parted = Object.entries(fields ?? {}).filter(([, value]) => value);
  return [
    turns ? dialogue(episode) : timed ? recital(viewer, episode, path) : instruction(episode),
    ...(parted.length > 0 ? [make('dl', { class: 'fields' }, ...parted.flatMap(([name, value]) =>
      [make('dt', {}, name === 'obj_name' ? 'Object' : capital(name.replaceAll('_', ' '))), make('dd', {}, value)]))] : []),
  ];
}

/** The fly-through along the reference path, and the pieces of the instruction that go with it. */
function referencePath(viewer: Viewer, map: MiniMap, { parts, parts_problem: problem, distance }: Episode, path: readonly number[]): HTMLElement[] {
  const list = parts && new PartList(viewer, map, parts, path);
  const said = problem ? [make('p', { class: 'problem' }, `${capital(problem)}.`)] : [];
  const pieces = list ? [make('h2', {}, 'Step by step'), list.element] : said;
  if (path.length === 0) return pieces;
  const flight = viewer.flight(path);
  const player = new Player(viewer, flight, list && ((seconds) => list.follow(flight.at(seconds))));
  return [...pieces, make('h2', {}, 'Reference path'), player.element,
    make('p', { class: 'note' }, `${counted(path.length, 'viewpoint')}, ${(distance ?? lengthOf(viewer.scan, path)).toFixed(1)} m`)];
}

/** An agent's trajectory: of the submission that the address names, else of the results file that this browser keeps. */
async function agentsWalk(viewer: Viewer, { episode, submission }: FoundEpisode, results: Results | undefined): Promise<readonly number[]> {
  const id = episode.instruction_id;
  const walk = indicesOf(viewer, submission ? await submittedWalk(api, submission, id) : results?.get(id)?.viewpoints);
  if (walk.includes(-1)) throw new Error(`${id}: the ${submission ? 'submission is' : 'results are'} of another building`);
  return walk;
}

function agentsPath(viewer: Viewer, { episode, submission }: FoundEpisode, walk: readonly number[]): HTMLElement[] {
  if (walk.length === 0) return [];
  const player = new Player(viewer, walk);
  player.element.setAttribute('aria-label', "Fly-through of the agent's trajectory");
  return [make('h2', {}, "The agent's trajectory"),
    ...(submission ? [make('p', {}, make('a', { href: `/submission?${new URLSearchParams({ id: submission })}` }, `Submission ${submission}`))] : []),
    player.element, ...verdict(viewer, episode, walk)];
}

/** Shows an episode in the panel, the map and the view. */
export async function showEpisode(panel: HTMLElement, viewer: Viewer, map: MiniMap, found: FoundEpisode): Promise<void> {
  const { episode, key, title, filters } = found;
  const { instruction_id: id, goal } = episode;
  document.title = `${id}, ${title} · Enfilade`;
  const head = new EpisodeHead(found);
  panel.append(head.element);
  if (episode.scan !== viewer.scan.scan) { // an address that was put together by hand
    panel.append(problems(new Error(`Episode ${id} is in ${episode.scan}, and the address names ${viewer.scan.scan}.`)),
      make('p', { class: 'buttons' }, make('a', { class: 'button', href: neighbourPage(found, id) }, `Open it in ${episode.scan}`)));
    return;
  }
  const path = indicesOf(viewer, episode.path);
  const results = await keptResults(key);
  let refused: unknown; // a submission that this client may not see leaves the rest
  const walk = await agentsWalk(viewer, found, results).catch((error: unknown) => { refused = error; return []; });
  const seen = indicesOf(viewer, goal?.viewpoints).filter((v) => v >= 0);
  viewer.setPath(path, seen);
  viewer.setOutlines(goal ? outlinesOf(viewer, goal) : []);
  map.setPath(path, walk, seen);
  panel.append(...says(viewer, episode, path));
  const looked = goal && goalPart(viewer, goal, path);
  if (looked) panel.append(looked);
  if (path.length === 0) panel.append(make('p', { class: 'note' }, 'The goal of this one is hidden.'));
  panel.append(...referencePath(viewer, map, episode, path), ...agentsPath(viewer, found, walk), ...(refused ? [problems(refused)] : []),
    episodeLinks(found, viewer.scan.viewpoints.some(({ rotation }) => rotation)));
  const others = otherInstructions(found);
  if (others) panel.append(others);
  // What is asked for now has its place at the end: nothing that is there moves.
  const later = [make('div'), make('div')] as const;
  panel.append(...later);
  const put = (box: HTMLElement, links: Promise<HTMLElement | undefined>) => void links.then((some) => { if (some) box.append(some); }, () => {});
  if (viewer.scan.runs) put(later[0], runLinks(api, episode, key));
  if (path.length > 0) put(later[1], submissionLinks(api, found));
  if (!isServersList(filters)) void new Listing(api).place(filters, results, id).then((place) => { if (place) head.show(place); }, () => {});
}
