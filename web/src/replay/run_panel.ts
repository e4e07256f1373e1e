/**
 * One run's steps through an episode: what the model saw, the panorama where it stood, the map with its trajectory, and the response,
 * the action and the feedback in words.
 */
import { canShowBuildings, noGraphicsText } from '../elements/graphics.ts';
import { make } from '../elements/page.ts';
import { shownText } from '../episodes/episode.ts';
import { degrees, wrapHeading } from '../geometry/geometry.ts';
import { type Plan, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { MapPanel, MiniMap, type Outline, Viewer } from '../viewer/enfilade-viewer.ts';
import {
  type At, callText, endText, episodePath, noResponseText, type Observation, outcomeWords, placeText, type Replay, type Step, turnText,
} from './runs.ts';

/** How large a place's mark is, degrees from its middle. */
const markSize = 1.1;

/** A small diamond in a direction, degrees. */
function diamond(heading: number, elevation: number): number[] {
  const rim = [[0, markSize], [markSize, 0], [0, -markSize], [-markSize, 0]] as const;
  return rim.flatMap(([right, up]) => [wrapHeading(degrees(heading + right)), degrees(elevation + up)]);
}

const part = (title: string, ...content: readonly (Node | string)[]): HTMLElement =>
  make('div', { class: 'replay-part' }, make('h3', {}, title), ...content);

export class RunPanel {
  readonly element = make('section', { class: 'replay-run' });
  readonly replay: Replay;
  /** Of the pictures; nothing where no step's place is known. */
  viewer: Viewer | undefined;
  private readonly view = make('div', { class: 'view' });
  private readonly saw = make('figure', { class: 'replay-saw' });
  private readonly mapBox = make('div', { class: 'map' });
  private readonly words = make('div', { class: 'replay-words' });
  private readonly unknown = make('p', { class: 'notice info replay-unknown' });
  private map: MiniMap | undefined;

  constructor(replay: Replay) {
    this.replay = replay;
    this.element.setAttribute('aria-label', `Run ${replay.run}`);
    const who = [replay.model, replay.prompt && `prompt ${replay.prompt}`].filter(Boolean).join(', ');
    this.element.append(
      make('header', {}, make('h2', {}, replay.run), ...(who ? [make('p', { class: 'note' }, who)] : []), ...this.verdict()),
      make('div', { class: 'replay-body' }, make('div', { class: 'replay-view' }, this.saw, this.view, this.unknown),
        make('div', { class: 'replay-side' }, this.mapBox,
          make('div', { class: 'replay-told' },
            part('Instruction', make('p', { class: 'instruction' }, shownText(replay.instruction, replay.task))), this.words))));
    this.unknown.hidden = this.saw.hidden = true;
  }

  private verdict(): HTMLElement[] {
    const { outcome } = this.replay;
    return outcome ? [make('span', { class: outcome.success ? 'badge good' : 'badge bad' }, outcome.success ? 'success' : 'failure')] : [];
  }

  /** Steps, and one more for the end. */
  get length(): number {
    return this.replay.steps.length + 1;
  }

  /** Opens the pictures, as far as there are any. What stands around them is there at once. @param number the step that is shown first */
  async open(number: number): Promise<void> {
    const { scan, steps } = this.replay;
    this.tell(number);
    const first = steps[0]?.at ?? this.replay.end.at;
    if (!scan || !first) return this.withoutView();
    if (!canShowBuildings()) return this.withoutView(noGraphicsText);
    try {
      this.viewer = await Viewer.open(this.view, { scan, ...pose(first), viewpoint: first.viewpoint });
    } catch (error) {
      return this.withoutView(`There are no pictures: ${error instanceof Error ? error.message : String(error)}`);
    }
    this.viewer.confine([]); // one looks around, and goes on by the steps
    this.map = new MiniMap(this.viewer);
    const panel = new MapPanel(this.viewer, this.map);
    this.mapBox.append(panel.element);
    const rooms = (plan: Plan) => plan.rooms.map((room) => ({ ...room, viewpoints: [] })); // none that one could go to
    void api.plan(scan).then((plan) => panel.setPlan({ ...plan, rooms: rooms(plan) })).catch(() => {}); // a map without walls
  }

  private withoutView(why = ''): void {
    this.element.classList.add('without-view');
    this.view.remove();
    this.mapBox.remove();
    if (why) this.sayUnknown(why);
  }

  private sayUnknown(text: string | undefined): void {
    this.unknown.hidden = !text;
    this.unknown.textContent = text ?? '';
  }

  /** Shows a step, from 1; length is the end. A larger number is the end too. */
  async show(number: number): Promise<void> {
    const { steps, end, place_problem: problem } = this.replay;
    const step = steps[number - 1];
    const at = step ? step.at : end.at;
    this.tell(number);
    if (!at && problem) this.sayUnknown(`${problem.charAt(0).toUpperCase()}${problem.slice(1)}.`);
    else if (this.viewer) this.sayUnknown(undefined);
    if (this.viewer) await this.stand(number, at, step);
  }

  /** What is said of a step, and what the model saw. */
  private tell(number: number): void {
    const step = this.replay.steps[number - 1];
    this.words.replaceChildren(...(step ? this.stepWords(step) : this.endWords()));
    this.showPictures(number, step);
  }

  /** The addresses of the pictures that the model saw at a step, in the order sent. @param number from 1 */
  pictures(number: number): string[] {
    const { run, episode, steps } = this.replay;
    return (steps[number - 1]?.pictures ?? []).map((_, k) => `${api.base}/api/v1/${episodePath(run, episode)}/steps/${number}/pictures/${k}`);
  }

  /** What the model saw, in the order sent. */
  private showPictures(number: number, step: Step | undefined): void {
    const addresses = this.pictures(number);
    this.saw.hidden = addresses.length === 0;
    if (!step || addresses.length === 0) return this.saw.replaceChildren();
    const names = (step.observation.places ?? []).map(({ name }) => name).join(', ');
    const image = (src: string, alt: string) => make('img', { src, alt });
    const strips = step.pictures!.every((caption) => caption === '');
    // A strip is two halves, which stand under each other where it is narrow.
    const frames = strips
      ? addresses.flatMap((src) => [image(src, `Left, ahead, right and behind, with the places ${names} marked`), image(src, '')])
        .map((one) => make('div', {}, one))
      : addresses.map((src, k) => make('div', {}, image(src, `Place ${step.pictures![k]}`), make('b', {}, step.pictures![k]!)));
    const scrolls = { class: 'replay-places', tabindex: '0', role: 'group', 'aria-label': 'What the model saw' };
    this.saw.replaceChildren(make('div', strips ? { class: 'replay-strip' } : scrolls, ...frames),
      make('figcaption', {}, strips ? 'What the model saw: left, ahead, right, behind' : 'What the model saw, in the order sent'));
  }

  private async stand(number: number, at: At | undefined, step: Step | undefined): Promise<void> {
    const viewer = this.viewer!;
    const { steps, end, outcome } = this.replay;
    this.element.classList.toggle('without-place', !at);
    if (!at) return;
    const index = (id: string) => viewpointIndex(viewer.scan, id);
    const indices = (ids: readonly string[]) => ids.map(index).filter((v) => v >= 0);
    const walked = indices([...steps.slice(0, number), ...(step ? [] : [end])].flatMap(({ at: there }) => there?.path ?? []));
    this.map!.setPath(indices(outcome?.path ?? []), walked, indices(outcome?.viewpoints ?? []));
    const viewpoint = index(at.viewpoint);
    viewer.setOutlines(step ? marks(step.observation, viewpoint, step) : []);
    await viewer.jump({ viewpoint, ...pose(at) });
    const next = step && moves(step) ? (steps[number] ?? end).at?.viewpoint : undefined;
    viewer.pointTo(next === undefined || next === at.viewpoint ? undefined : index(next));
  }

  private stepWords(step: Step): HTMLElement[] {
    const { observation, call, told, text, prompt_tokens, answer_tokens } = step;
    const [into, out] = [prompt_tokens, answer_tokens].map((count) => (count ?? 0).toLocaleString('en-US'));
    const tokens = prompt_tokens === undefined && answer_tokens === undefined ? [] : [make('p', { class: 'note' }, `${into} tokens in, ${out} out`)];
    return [
      part('Response', text ? make('p', { class: 'replay-thought' }, text) : make('p', { class: 'note' }, noResponseText(step))),
      part('Action', make('p', {}, make('code', { class: call ? 'replay-call' : 'replay-call none' }, callText(call)))),
      part('Feedback', make('p', {}, told)), ...tokens, observationPart(observation)];
  }

  private endWords(): HTMLElement[] {
    const { end, outcome } = this.replay;
    const words = outcomeWords(this.replay);
    return [part('The end', make('p', {}, `It ${endText(end)}.`),
      ...(words ? [make('p', { class: outcome!.success ? 'done' : 'problem' }, words),
        ...(this.viewer ? [make('p', { class: 'note' }, 'Map: the reference path in blue, the trajectory in purple.')] : [])] : []))];
  }

  /** What a step does, for lists. */
  title(number: number): string {
    const step = this.replay.steps[number - 1];
    return step ? callText(step.call) : this.replay.end.ending;
  }

  dispose(): void {
    this.map?.dispose();
    this.viewer?.dispose();
    this.element.remove();
  }
}

const pose = ({ heading, elevation }: Pick<At, 'heading' | 'elevation'>) => ({ heading: degrees(heading), elevation: degrees(elevation) });

const moves = ({ call }: Pick<Step, 'call'>): boolean => call?.tool === 'go_to' || call?.tool === 'back_to';

/** The letters of the places in the picture, as the model had them; where it went has a word more. */
function marks({ heading, places = [], things = [] }: Observation, viewpoint: number, step: Step): Outline[] {
  const chosen = moves(step) ? step.call!.argument.trim().toUpperCase() : '';
  return [
    ...places.map(({ name, turn, elevation }) =>
      ({ viewpoint, label: name === chosen ? `${name}: goes here` : name, rim: diamond(heading + turn, elevation) })),
    ...things.map(({ name, category, turn, elevation }) => ({ viewpoint, label: `${name}: ${category}`, rim: diamond(heading + turn, elevation) }))];
}

/** All else that the model received at the step. */
function observationPart({ here, heading, places = [], things = [], told }: Observation): HTMLElement {
  return make('details', { class: 'replay-part' }, make('summary', {}, 'Observation'),
    ...(told ? [make('p', {}, told)] : []),
    make('p', {}, here ? `At ${here}, heading ${Math.round(heading)}°.` : `Heading ${Math.round(heading)}°.`),
    ...(places.length > 0 ? [make('ul', {}, ...places.map((place) => make('li', {}, make('b', {}, place.name), `: ${placeText(place)}`,
      place.what ? `; there: ${place.what}` : '', place.visited ? '; visited' : place.seen_before ? '; seen before' : '')))] : []),
    ...(things.length > 0 ? [make('ul', {}, ...things.map(({ name, category, turn }) =>
      make('li', {}, make('b', {}, name), `: ${category}, ${turnText(turn)}`)))] : []));
}
