/** From the link to the thanks: consent, instructions, task after task, the end. */
import type { Collection } from '../collections.ts';
import { action } from '../forms.ts';
import { markdown } from '../markdown.ts';
import { addHeader, byId, make, problems, run } from '../page.ts';
import { ServerError } from '../scan.ts';
import { ending } from './ending.ts';
import { arrive, type Submission, type Task, type Visit, type WorkApi } from './visit.ts';

/** What a task's page works with. */
export interface Desk {
  readonly collection: Collection;
  readonly task: Task;
  /** Absent in a preview, where nothing can be handed in. */
  readonly api: WorkApi | undefined;
  /** To be called with what the server answered to the end of the task. */
  readonly proceed: (visit: Visit) => void;
}

/** Fills the page's main part with a task. Resolves with what ends it. */
export type ShowTask = (main: HTMLElement, desk: Desk) => Promise<() => void>;

/** What the server says of a walk. */
function resultOf({ walked }: Visit): HTMLElement[] {
  if (walked?.bonus === undefined) return [];
  return [walked.bonus
    ? make('p', { class: 'done' }, 'You stopped less than 3 m from the goal: this walk earns the bonus.')
    : make('p', { class: 'problem' }, 'You stopped 3 m or more from the goal: no bonus for this walk.')];
}

class Flow {
  private readonly main = byId('main');
  private readonly collection: Collection;
  private readonly api: WorkApi;
  private readonly show: ShowTask;
  private end: () => void = () => {};

  constructor(collection: Collection, api: WorkApi, show: ShowTask) {
    this.collection = collection;
    this.api = api;
    this.show = show;
  }

  /** @param arriving the worker sees the page for the first time since it was loaded */
  go(visit: Visit, arriving = false): void {
    if (!visit.consented) return this.askConsent();
    if (visit.finished || visit.why) return this.finish(visit);
    if (visit.task) return void this.begin(visit.task);
    if (arriving && visit.done === 0) return this.explain();
    this.between(visit);
  }

  private page(...content: HTMLElement[]): void {
    this.end();
    this.end = () => {};
    this.main.classList.remove('wide');
    this.main.replaceChildren(make('div', { class: 'narrow' }, ...content));
    this.main.querySelector('h1')?.focus();
    scrollTo(0, 0);
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
    this.page(this.title(this.collection.title), markdown(this.collection.consent),
      make('p', { class: 'buttons' }, agree, no), said);
  }

  private explain(): void {
    const said = make('div');
    this.page(this.title(this.collection.title), markdown(this.collection.instructions),
      make('p', {}, this.next('Begin', said)), said);
  }

  private between(visit: Visit): void {
    const said = make('div');
    const count = visit.of ? `${visit.done} of ${visit.of}` : String(visit.done);
    this.page(this.title(visit.done > 0 ? 'Received, thank you' : this.collection.title), ...resultOf(visit),
      make('p', {}, visit.done > 0 ? `You have handed in ${count}.` : 'You gave the task back.'),
      make('p', {}, this.next('The next one', said)), said,
      make('p', { class: 'note' }, 'Or close this page: all that you handed in is kept.'));
  }

  private next(text: string, said: HTMLElement): HTMLElement {
    return action(text, said, async () => this.go(await this.api.lease()), { class: 'main' });
  }

  private finish(visit: Visit): void {
    this.page(...resultOf(visit), ending(visit, () => {
      this.api.lease().then((anew) => this.go(anew), (error: unknown) => this.page(problems(error)));
    }));
  }

  private async begin(task: Task): Promise<void> {
    this.end();
    this.end = () => {};
    try {
      this.main.replaceChildren();
      this.main.classList.add('wide');
      this.end = await this.show(this.main, {
        collection: this.collection, task, api: this.api, proceed: (visit) => this.go(visit),
      });
    } catch (error) {
      this.page(problems(error));
    }
  }
}

/** The panel that a task's page begins with: title, rules, and in a preview all that a worker wants to know. */
export function taskPanel({ collection, api }: Desk): HTMLElement {
  const panel = make('div', { class: 'panel' }, make('h1', { tabindex: '-1' }, collection.title));
  if (!api) panel.append(make('p', { class: 'notice' }, 'This is a preview with an example. Accept the task to begin.'),
    make('details', {}, make('summary', {}, 'Consent'), markdown(collection.consent)));
  const rules = make('details', {}, make('summary', {}, 'What is asked'), markdown(collection.instructions));
  rules.open = !api;
  panel.append(rules);
  return panel;
}

const lost = 'This task lay still for so long that it was given to somebody else.';
/** The lease is gone. */
export const lostText = `${lost} Load the page again for another one.`;
/** As lostText, where there is a text to be saved. */
export const lostDraftText = `${lost} Copy what you want to keep, and load the page again for another one.`;

/** What to say when the server takes no more of a task. */
function explainLoss(error: unknown): Error {
  const { code, status } = error instanceof ServerError ? error : { code: '', status: 0 };
  if (code === 'lease-expired') return new Error(lostText);
  if (status === 401) return new Error('You were away for a day, and have to come in anew: load the page again. Nothing is lost.');
  return error instanceof Error ? error : new Error(String(error));
}

/** Hands a task's work in; what was kept of it here is forgotten then. */
export async function handIn({ api, task, proceed }: Desk, drafts: { forget(): void }, work: Submission): Promise<void> {
  const visit = await api!.handIn(task.task!, work).catch((error: unknown) => { throw explainLoss(error); });
  drafts.forget();
  proceed(visit);
}

/** Runs a page of work. */
export const work = (kind: Collection['kind'], show: ShowTask): void =>
  run(() => visit(kind, show), 'This link does not work', []);

async function visit(kind: Collection['kind'], show: ShowTask): Promise<void> {
  const main = byId('main');
  const arrival = await arrive();
  const { collection } = arrival;
  if (collection.kind !== kind) {
    return location.replace(`${collection.kind === 'walk' ? '/walk' : '/collect'}${location.search}`);
  }
  addHeader(collection.synthetic, []);
  document.title = `${collection.title} · Enfilade`;
  if (!arrival.preview) return new Flow(collection, arrival.api, show).go(arrival.visit, true);
  if (!arrival.example) {
    main.append(make('div', { class: 'narrow' }, make('h1', {}, collection.title), markdown(collection.instructions)));
    return;
  }
  main.classList.add('wide');
  await show(main, { collection, task: arrival.example, api: undefined, proceed: () => {} });
}
