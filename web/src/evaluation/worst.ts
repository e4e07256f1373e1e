/** Episodes of a submission, the worst first: pictures of the goal and of where it stopped, and the trajectory on a map. */
import { make } from '../elements/page.ts';
import { stillAt } from '../episodes/outcome_part.ts';
import { withoutTurns } from '../episodes/results.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { MiniMap } from '../viewer/mini_map.ts';
import type { Phase } from './phases.ts';
import { factorOf, format, unitOf } from './ranking.ts';
import { arrival, type Entry, faceTowards } from './trajectory.ts';

export interface SubmittedEpisode {
  readonly episode: string;
  readonly scan: string;
  readonly instruction: string;
  /** Viewpoint ids; absent in continuous environments, as the trajectory is. */
  readonly path?: readonly string[];
  readonly trajectory?: readonly Entry[];
  /** By column; shares from 0 to 1. */
  readonly values: Readonly<Record<string, number | null>>;
}

function picture(scan: Scan, viewpoint: number, heading: number, caption: string, of: string): HTMLElement[] {
  const { id, rotation } = scan.viewpoints[viewpoint] ?? {};
  if (id === undefined || !rotation) return []; // a scan without pictures
  const src = api.face(scan.scan, id, 'colour', faceTowards(rotation, heading));
  const image = make('img', { src, alt: `${caption}, episode ${of}`, loading: 'lazy', width: '256', height: '256' });
  return [make('figure', {}, image, make('figcaption', {}, caption))];
}

/** Reference path and trajectory; drawn when it is opened. */
function mapOf(scan: Scan, path: readonly string[], walk: readonly string[], end: Entry): HTMLElement {
  const indices = (ids: readonly string[]) => ids.map((id) => viewpointIndex(scan, id));
  const box = make('div', { class: 'map' });
  const details = make('details', {}, make('summary', {}, 'Map'), box,
    make('p', { class: 'note' }, 'Wide: the reference path. Narrow: the trajectory of this submission, with a ring where it stopped.'));
  details.addEventListener('toggle', () => {
    if (!details.open || box.childElementCount > 0) return;
    const map = new MiniMap(stillAt(scan, end[0], end[1]));
    map.element.setAttribute('aria-label', 'Floor plan with the reference path and the trajectory');
    map.setPath(indices(path), indices(walk));
    box.append(map.element);
    void map.loadPlan(api, true);
  });
  return details;
}

/** "SPL 0.0 %, NE 9.21 m": what ranks, and the errors. */
function valuesText({ values }: SubmittedEpisode, { columns, primary }: Phase): string {
  return columns.filter(({ name, better }) => name === primary || better === 'lower').map((column) => {
    const value = values[column.name];
    return `${column.short} ${typeof value === 'number' ? `${format(value * factorOf(column), column)} ${unitOf(column)}` : 'unknown'}`;
  }).join(', ');
}

/** Fills a card in when its building is known. */
function fill(card: HTMLElement, pictures: HTMLElement, one: SubmittedEpisode, scan: Scan): void {
  const { path = [], trajectory = [], episode } = one;
  const [goal, end] = [arrival(scan, path), trajectory.at(-1)];
  if (goal) pictures.append(...picture(scan, goal.at, goal.heading, 'The goal', episode));
  if (!end) return;
  pictures.append(...picture(scan, viewpointIndex(scan, end[0]), end[1], 'Where it stopped', episode));
  card.append(mapOf(scan, path, withoutTurns(trajectory.map(([id]) => id)), end));
}

/** @param linkOf the address of an episode's page */
export function worstList(list: readonly SubmittedEpisode[], phase: Phase, linkOf: (episode: string) => string): HTMLElement {
  const scans = new Map<string, Promise<Scan>>();
  const scanOf = (name: string): Promise<Scan> => {
    const known = scans.get(name) ?? api.scan(name);
    scans.set(name, known);
    return known;
  };
  return make('ol', { class: 'cards worst' }, ...list.map((one) => {
    const pictures = make('div', { class: 'pair' });
    const body = make('div', { class: 'card-body' }, make('h3', {}, make('a', { href: linkOf(one.episode) }, one.episode)),
      make('p', {}, one.instruction), make('p', { class: 'note' }, valuesText(one, phase)));
    if (one.trajectory) scanOf(one.scan).then((scan) => fill(body, pictures, one, scan), () => undefined); // no pictures then
    return make('li', { class: 'card' }, pictures, body);
  }));
}
