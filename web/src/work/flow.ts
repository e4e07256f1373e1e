/** From the link to the thanks: consent, questions, instructions, task after task, the end. */
import type { Collection, Kind } from '../collecting/collections.ts';
import { action } from '../elements/forms.ts';
import { canShowBuildings, noGraphics, workersWayBack } from '../elements/graphics.ts';
import { markdown } from '../elements/markdown.ts';
import { addHeader, byId, make } from '../elements/page.ts';
import { reach } from '../server/api.ts';
import { questionForm } from './ask.ts';
import { conditions, notAccepted, practised, progress } from './conditions.ts';
import { ending } from './ending.ts';
import { explained, explainLoss, isOutOfReach, troubles } from './refusals.ts';
import { Tabs } from './tabs.ts';
import { arrive, collectionOf, type Submission, type Task, type Visit, type WorkApi } from './visit.ts';

/** What a task's page works with. */
export interface Desk {
  readonly collection: Collection;
  readonly task: Task;
  /** Absent in a preview, where nothing can be submitted. */
  readonly api: WorkApi | undefined;
  /** Absent in a preview. */
  readonly visit: Visit | undefined;
  /** To be called with what the server answered to the end of the task. */
  readonly proceed: (visit: Visit) => void;
}

/** A task on the page. */
interface TaskPage {
  /** Sends what is not sent yet. */
  save(): Promise<void>;
  dispose(): void;
}

/** Fills the page's main part with a task. */
export type ShowTask = (main: HTMLElement, desk: Desk) => Promise<TaskPage>;

const retryMs = 5000;

class Flow {
  private readonly main = byId('main');
  private readonly collection: Collection;
  private readonly api: WorkApi;
  private readonly show: ShowTask;
  private shown: TaskPage | undefined;
  /** The newest that the server told: answers to drafts tell nothing of it. */
  private visit: Visit;

  constructor(collection: Collection, api: WorkApi, show: ShowTask, visit: Visit) {
    this.collection = collection;
    this.api = api;
    this.show = show;
    this.visit = visit;
    addEventListener('pagehide', () => void this.shown?.save());
  }

  /** @param arriving the worker sees the page for the first time since it was loaded */
  go(visit: Visit, arriving = false): void {
    this.visit = visit;
    if (!visit.consented) return this.askConsent();
    if (visit.screened_out) return this.finish({ ...visit, why: 'screened-out' });
    // After a task its receipt comes first; the next one is asked for then, and the questions come.
    const asking = arriving || visit.why === 'questions';
    if (asking && visit.questions?.length) return this.ask(visit.questions);
    if (visit.practised) return this.between();
    if (visit.finished || (visit.why && visit.why !== 'questions')) return this.finish(visit);
    if (visit.task) return void this.begin(visit.task);
    if (arriving && visit.done === 0) return this.explain();
    if (visit.done > 0 && visit.done === visit.of && !visit.practice) return void this.end();
    this.between();
  }

  /** All is done: no press is asked for to hear why there is no more. */
  private async end(): Promise<void> {
    try {
      this.visit = await this.api.lease();
    } catch {
      return this.between();
    }
    if (this.visit.task) this.between(); // a place was left meanwhile
    else this.go({ ...this.visit, why: this.visit.why ?? 'finished' });
  }

  /** Another tab goes on from here. */
  async giveWay(): Promise<void> {
    await this.shown?.save();
    const here = make('button', { type: 'button', class: 'main' }, 'Go on here instead');
    here.addEventListener('click', () => location.reload());
    this.page(this.title('You opened this in another tab'),
      make('p', {}, 'Go on there: your work was saved, and this tab has stopped, so that the two do not overwrite each other.'), make('p', {}, here));
  }

  private page(...content: HTMLElement[]): void {
    this.leave();
    this.main.classList.remove('wide');
    this.main.replaceChildren(make('div', { class: 'narrow' }, ...content));
    this.main.querySelector('h1')?.focus();
    scrollTo(0, 0);
  }

  private leave(): void {
    this.shown?.dispose();
    this.shown = undefined;
  }

  private title(text: string): HTMLElement {
    return make('h1', { tabindex: '-1' }, text);
  }

  private askConsent(): void {
    const said = make('div');
    const agree = action('I agree', said, async () => this.go(await this.api.consent(), true), { class: 'main' });
    const no = make('button', { type: 'button' }, 'I do not agree');
    no.addEventListener('click', () => this.page(this.title('Nothing was kept'),
      make('p', {}, 'You can close this page. Nothing that you did here is kept. Should you change your mind, load it again.')));
    this.page(this.title(this.collection.title), conditions(this.collection, this.visit), markdown(this.collection.consent),
      make('p', { class: 'buttons' }, agree, no), said);
  }

  private ask(questions: NonNullable<Visit['questions']>): void {
    this.page(this.title(this.visit.done > 0 ? 'A question in between' : questions.length === 1 ? 'A question first' : 'Some questions first'),
      questionForm(questions, this.api, (visit) => this.go(visit, true)));
  }

  private explain(): void {
    const said = make('div');
    this.page(this.title(this.collection.title), ...notAccepted(this.visit), markdown(this.collection.instructions),
      make('p', {}, this.next(this.visit.practice ? 'Start with practice' : 'Start', said)), said);
  }

  private between(): void {
    const said = make('div');
    const { done, of, practice = 0, practised: result } = this.visit;
    const title = result ? 'Practice done' : done > 0 ? 'Received, thank you' : this.collection.title;
    const count = of === undefined ? String(done) : `${done} of ${of}`;
    const words = result ? (practice > 0 ? 'There is more practice.' : 'From now on it counts.') : done > 0 ? `You have submitted ${count}.` : 'You skipped the task.';
    this.page(this.title(title), ...practised(this.visit), ...notAccepted(this.visit), make('p', {}, words),
      make('p', {}, this.next('Next', said)), said,
      ...(result ? [] : [make('p', { class: 'note' }, 'Or close this page: all that you submitted is kept.')]));
  }

  private next(text: string, said: HTMLElement): HTMLElement {
    return action(text, said, async () => this.go(await this.api.lease()), { class: 'main' });
  }

  private finish(visit: Visit): void {
    this.page(...notAccepted(visit), ending(visit, () => {
      this.api.lease().then((anew) => this.go(anew), (error: unknown) => this.page(troubles(error)));
    }));
  }

  private async begin(task: Task): Promise<void> {
    this.leave();
    try {
      this.main.replaceChildren();
      this.main.classList.add('wide');
      this.shown = await this.show(this.main, {
        collection: this.collection, task, api: this.api, visit: this.visit, proceed: (visit) => this.go(visit),
      });
    } catch (error) {
      const said = make('div');
      this.page(this.title('The building cannot be shown'), troubles(error), make('p', {}, this.next('Try again', said)), said);
    }
  }
}

/** The panel that a task's page begins with: title, rules, and in a preview all that a worker wants to know. */
export function taskPanel({ collection, api, visit }: Desk): HTMLElement {
  const panel = make('div', { class: 'panel' }, make('h1', { tabindex: '-1' }, collection.title));
  if (visit) panel.append(progress(visit));
  if (!api) panel.append(make('p', { class: 'notice' }, 'This is a preview with an example. Accept the task to begin.'), conditions(collection),
    make('details', {}, make('summary', {}, 'Consent'), markdown(collection.consent)));
  const rules = make('details', {}, make('summary', {}, 'Instructions'), markdown(collection.instructions));
  rules.open = !api;
  panel.append(rules);
  return panel;
}

/**
 * Submits a task's work; what was kept of it here is forgotten then. While the server is out of reach it is tried again:
 * sent twice, the same work is one.
 * @param waiting called when it begins to wait
 */
export async function submit({ api, task, proceed }: Desk, drafts: { forget(): void }, work: Submission, waiting: () => void): Promise<void> {
  for (;;) {
    try {
      const visit = await api!.submit(task.task!, work);
      drafts.forget();
      return proceed(visit);
    } catch (error) {
      if (!isOutOfReach(error)) throw explainLoss(error);
      waiting();
      await new Promise((resolve) => setTimeout(resolve, retryMs));
    }
  }
}

/** How the tasks of a page are shown, by kind. */
export type Shows = Readonly<Partial<Record<Kind, ShowTask>>>;

/** The page for workers of a collection. */
const pageOf = (kind: Kind): string => (['write', 'describe', 'guide'].includes(kind) ? '/collect' : '/walk');

/** Loads the page anew, once the server answers: without a server there would be no page. */
function loadAnew(): void {
  setTimeout(() => { reach('/api/v1/session').then(() => location.reload(), loadAnew); }, retryMs);
}

/** Runs a page of work. */
export function work(shows: Shows): void {
  addHeader({ synthetic: false }, []); // at once: what comes later moves nothing
  visit(shows).catch((error: unknown) => {
    const main = byId('main');
    main.classList.remove('wide');
    main.replaceChildren(make('div', { class: 'narrow' }, make('h1', { tabindex: '-1' }, explained(error)), troubles(error)));
    if (!isOutOfReach(error)) return;
    main.firstElementChild!.append(make('p', {}, 'This page tries again by itself. Nothing is lost.'));
    loadAnew();
  });
}

async function visit(shows: Shows): Promise<void> {
  const main = byId('main');
  const query = new URLSearchParams(location.search);
  collectionOf(query); // before anything that takes time
  if (!canShowBuildings()) return main.replaceChildren(noGraphics(workersWayBack(query)));
  const tabs = new Tabs(location.search);
  const took = await tabs.takeOver();
  const arrival = await arrive();
  const { collection } = arrival;
  const show = shows[collection.kind];
  if (!show) return location.replace(`${pageOf(collection.kind)}${location.search}`);
  addHeader(collection, []);
  document.title = `${collection.title} · Enfilade`;
  if (!arrival.preview) {
    const flow = new Flow(collection, arrival.api, show, arrival.visit);
    tabs.giveWay(() => flow.giveWay());
    flow.go(arrival.visit, true);
    if (took) document.body.append(make('p', { class: 'toast', role: 'status' }, 'Your other tab with this page has stopped; go on here.'));
    return;
  }
  if (!arrival.example) {
    main.append(make('div', { class: 'narrow' }, make('h1', {}, collection.title), conditions(collection), markdown(collection.instructions)));
    return;
  }
  main.classList.add('wide');
  await show(main, { collection, task: arrival.example, api: undefined, visit: undefined, proceed: () => {} });
}
