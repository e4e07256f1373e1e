/** One run's walk of an episode: the panorama where a step stood, the map with the way there, and what was thought, called and told. */
import { make } from '../elements/page.ts';
import { degrees, wrapHeading } from '../geometry/geometry.ts';
import { type Plan, viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { MapPanel, MiniMap, type Outline, Viewer } from '../viewer/enfilade-viewer.ts';
import {
  type At, callText, endText, type Observation, placeText, type Replay, type Step, turnText,
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
  /** Of the pictures; nothing where no step's place is known. */
  viewer: Viewer | undefined;
  private readonly replay: Replay;
  private readonly view = make('div', { class: 'view' });
  private readonly mapBox = make('div', { class: 'map' });
  private readonly words = make('div', { class: 'replay-words' });
  private readonly unknown = make('p', { class: 'notice info replay-unknown' });
  private map: MiniMap | undefined;

  constructor(replay: Replay) {
    this.replay = replay;
    this.element.setAttribute('aria-label', `Run ${replay.run}`);
    const who = [replay.model, replay.prompt && `prompt ${replay.prompt}`].filter(Boolean).join(', ');
    this.element.append(
      make('header', {}, make('h2', {}, replay.run), ...(who ? [make('p', { class: 'note' }, who)] : [])),
      make('div', { class: 'replay-body' }, make('div', { class: 'replay-view' }, this.view, this.unknown),
        make('div', { class: 'replay-side' }, this.mapBox, this.words)));
    this.unknown.hidden = true;
  }

  /** Steps, and one more for the end. */
  get length(): number {
    return this.replay.steps.length + 1;
  }

  /** Opens the pictures, as far as there are any. */
  async open(): Promise<void> {
    const { scan, steps } = this.replay;
    const first = steps[0]?.at ?? this.replay.end.at;
    if (!scan || !first) return this.withoutView();
    try {
      this.viewer = await Viewer.open(this.view, { scan, ...pose(first), viewpoint: first.viewpoint });
    } catch (error) {
      return this.withoutView(error instanceof Error ? error.message : String(error));
    }
    this.viewer.confine([]); // one looks around, and walks by the steps
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
    if (why) this.sayUnknown(`There are no pictures: ${why}`);
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
    this.words.replaceChildren(...(step ? this.stepWords(step) : this.endWords()));
    if (!at && problem) this.sayUnknown(`${problem.charAt(0).toUpperCase()}${problem.slice(1)}.`);
    else if (this.viewer) this.sayUnknown(undefined);
    if (this.viewer) await this.stand(number, at, step);
  }

  private async stand(number: number, at: At | undefined, step: Step | undefined): Promise<void> {
    const viewer = this.viewer!;
    this.element.classList.toggle('without-place', !at);
    if (!at) return;
    const index = (id: string) => viewpointIndex(viewer.scan, id);
    const walked = [...this.replay.steps.slice(0, number), ...(step ? [] : [this.replay.end])]
      .flatMap(({ at: there }) => there?.path ?? []).map(index).filter((v) => v >= 0);
    this.map!.setPath([], walked);
    const viewpoint = index(at.viewpoint);
    viewer.setOutlines(step ? marks(step.observation, viewpoint, step) : []);
    await viewer.jump({ viewpoint, ...pose(at) });
  }

  private stepWords({ observation, call, told, text, prompt_tokens, answer_tokens }: Step): HTMLElement[] {
    const tokens = prompt_tokens === undefined && answer_tokens === undefined ? []
      : [make('p', { class: 'note' }, `${prompt_tokens ?? 0} tokens in, ${answer_tokens ?? 0} out`)];
    return [
      part('Thought', text ? make('p', { class: 'replay-thought' }, text) : make('p', { class: 'note' }, 'Nothing was written beside the call.')),
      part('Call', make('p', {}, make('code', { class: call ? 'replay-call' : 'replay-call none' }, callText(call)))),
      part('Told', make('p', {}, told)), ...tokens, seenPart(observation)];
  }

  private endWords(): HTMLElement[] {
    return [part('The end', make('p', {}, `It ${endText(this.replay.end)}.`))];
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

/** The letters of the places in the picture, as the model had them; where it went has a word more. */
function marks({ heading, places = [], things = [] }: Observation, viewpoint: number, { call }: Step): Outline[] {
  const chosen = call?.tool === 'go_to' || call?.tool === 'back_to' ? call.argument.trim().toUpperCase() : '';
  return [
    ...places.map(({ name, turn, elevation }) => ({ viewpoint, label: name === chosen ? `${name}: goes here` : name, rim: diamond(heading + turn, elevation) })),
    ...things.map(({ name, category, turn, elevation }) => ({ viewpoint, label: `${name}: ${category}`, rim: diamond(heading + turn, elevation) }))];
}

/** All else that was known at the step. */
function seenPart({ here, heading, places = [], things = [], told }: Observation): HTMLElement {
  return make('details', { class: 'replay-part' }, make('summary', {}, 'What it knew'),
    ...(told ? [make('p', {}, told)] : []),
    make('p', {}, here ? `At ${here}, looking towards ${Math.round(heading)}°.` : `Looking towards ${Math.round(heading)}°.`),
    ...(places.length > 0 ? [make('ul', {}, ...places.map((place) => make('li', {}, make('b', {}, place.name), `: ${placeText(place)}`,
      place.what ? `; there: ${place.what}` : '', place.visited ? '; visited' : place.seen_before ? '; seen before' : '')))] : []),
    ...(things.length > 0 ? [make('ul', {}, ...things.map(({ name, category, turn }) => make('li', {}, make('b', {}, name), `: ${category}, ${turnText(turn)}`)))] : []));
}
