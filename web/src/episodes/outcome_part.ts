/** The outcome of a trajectory on a page: its words, and both paths on a map. */
import { make } from '../elements/page.ts';
import { type Scan, viewpointIndex } from '../scan/scan.ts';
import type { Api } from '../server/api.ts';
import { type MapSource, MiniMap } from '../viewer/mini_map.ts';
import '../viewer/styled.ts';
import { type Outcome, outcomeText, ruleText } from './outcome.ts';

/** A map's place without a viewer: where a trajectory stopped. */
export function stillAt(scan: Scan, viewpoint: string, heading = 0): MapSource {
  return {
    scan, pose: { viewpoint: Math.max(0, viewpointIndex(scan, viewpoint)), heading, elevation: 0, vfov: 1 },
    onChange: () => () => {}, go: () => Promise.resolve(false),
  };
}

/** The heading that says it: for the focus. */
export const outcomeHeading = ({ success }: Outcome): HTMLElement =>
  make('h2', { tabindex: '-1' }, success ? 'Success: you found the goal' : 'No success: you did not reach the goal');

/** The words, and the map with both paths. @param who as of outcomeText() */
export function outcomePart(api: Api, source: MapSource, outcome: Outcome, who = 'You'): HTMLElement {
  const indices = (ids: readonly string[]) => ids.map((id) => viewpointIndex(source.scan, id)).filter((v) => v >= 0);
  const map = new MiniMap(source);
  map.setPath(indices(outcome.path), indices(outcome.walk), indices(outcome.viewpoints));
  map.element.setAttribute('aria-label', 'Floor plan with the reference path and the trajectory');
  void map.loadPlan(api, true);
  const answer = outcome.answer === undefined ? '' : outcome.answer === null ? ' No object was named.'
    : outcome.answer ? ' The named object is the right one.' : ' The named object is another one.';
  return make('div', { class: 'outcome' },
    make('p', { class: outcome.success ? 'done' : 'problem' }, `${outcomeText(outcome, who)}${answer}`),
    make('p', { class: 'note' }, ruleText(outcome)),
    make('div', { class: 'map' }, map.element),
    make('p', { class: 'note' }, `Blue: the reference path. Purple: ${who === 'You' ? 'your' : 'the'} trajectory.`,
      outcome.viewpoints.length > 0 ? ' Yellow: where the goal is.' : ''));
}
