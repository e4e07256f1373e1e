/** Guiding along a path: workers walk it and say what they see and do, each word with its time. */
import type { Entry, TimedWord } from '../collecting/collections.ts';
import { action, twice } from '../elements/forms.ts';
import { counted, make, say } from '../elements/page.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { ServerError } from '../server/api.ts';
import { Viewer } from '../viewer/enfilade-viewer.ts';
import { Drafts, type DraftState } from './drafts.ts';
import { type Desk, submit, taskPanel } from './flow.ts';
import { tooShort, wordsIn } from './hints.ts';
import { Looks } from './looks.ts';
import { Recorder } from './recorder.ts';
import { lostDraftText, sentences } from './refusals.ts';
import { canSpeak, Speech } from './speech.ts';
import { outOfReachText, storage } from './storage.ts';
import { Tour } from './tour.ts';
import { rounded } from './walk_task.ts';
import { retimed } from './word_times.ts';

interface Draft {
  readonly text: string;
  readonly words: readonly TimedWord[];
  readonly steps: readonly Entry[];
  readonly pasted: number;
  readonly spoken: boolean;
}

const mostCharacters = 2000;
const muchPasted = 40;
const draftTexts: Record<DraftState, string> = { saving: 'Saving…', saved: 'Draft saved.', here: outOfReachText('text'), lost: lostDraftText };
const short = (seconds: number): number => Number(Math.max(seconds, 0).toFixed(2));

export class GuideTask {
  readonly viewer: Viewer;
  private readonly desk: Desk;
  private readonly recorder: Recorder;
  private readonly drafts: Drafts<Draft>;
  private readonly goal: number;
  private readonly speech: Speech | undefined;
  private readonly text = make('textarea', { id: 'directions', rows: '7', maxlength: String(mostCharacters), 'aria-describedby': 'refusal words' });
  private readonly refusal = make('div', { id: 'refusal', role: 'alert' });
  private readonly count = make('span', { id: 'words' });
  private readonly draftSaid = make('span', { role: 'status' });
  private readonly said = make('div');
  private readonly speak = make('button', { type: 'button', 'aria-pressed': 'false' }, 'Speak');
  private words: TimedWord[] = [];
  private pasted = 0;
  private spoken = false;
  private arrived = false;
  private steps = 0;

  static async open(main: HTMLElement, desk: Desk): Promise<GuideTask> {
    const { task, api } = desk;
    const [view, side] = [make('div', { class: 'view' }), make('aside', { class: 'side work', 'aria-label': 'Your task' })];
    main.append(view, side);
    const drafts = new Drafts<Draft>(`guide/${task.task}`, storage, (draft) => api!.keepDraft(task.task!, draft));
    const draft = api && drafts.begin(task.draft as Draft | undefined);
    // At first towards the second viewpoint: a start's heading is random, and often shows a wall.
    const [first, second = first] = task.path!;
    const last = draft?.steps.at(-1);
    const viewer = await Viewer.open(view, { scan: task.scan, ...(last ?? { viewpoint: first!, towards: second! }) });
    return new GuideTask(desk, viewer, drafts, draft, side);
  }

  private constructor(desk: Desk, viewer: Viewer, drafts: Drafts<Draft>, draft: Draft | undefined, side: HTMLElement) {
    this.desk = desk;
    this.viewer = viewer;
    this.drafts = drafts;
    const path = desk.task.path!.map((id) => viewpointIndex(viewer.scan, id));
    this.goal = path.at(-1)!;
    viewer.setPath(path);
    viewer.confine(path);
    this.recorder = new Recorder(this.here, viewer.pose, draft?.steps ?? []);
    this.steps = this.recorder.steps;
    this.arrived = (draft?.steps ?? []).some(({ viewpoint }) => viewpoint === desk.task.path!.at(-1));
    if (canSpeak() && desk.api) {
      this.speech = new Speech(desk.collection.language ?? 'en-US', () => this.recorder.seconds,
        (text, since) => this.hear(text, since), (problem) => this.listening(problem));
    }
    drafts.onState((state) => say(this.draftSaid, draftTexts[state]));
    side.append(this.panel(new Tour(viewer, path, new Looks(), () => {})));
    this.resume(draft);
    viewer.onChange(() => this.moved());
    this.text.addEventListener('input', () => this.typed());
    this.text.addEventListener('paste', (event) => { this.pasted += event.clipboardData?.getData('text').length ?? 0; });
  }

  save(): Promise<void> {
    return this.drafts.save();
  }

  dispose(): void {
    this.speech?.stop();
    this.drafts.dispose();
    this.viewer.dispose();
  }

  private get here(): string {
    return this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!.id;
  }

  private panel(tour: Tour): HTMLElement {
    const panel = taskPanel(this.desk);
    const done = action('Submit', this.said, () => this.submit(), { class: 'main' });
    const giveBack = twice('Skip this path', 'Skip it? You will not be offered it again', this.said, async () => {
      const visit = await this.desk.api!.giveBack(this.desk.task.task!);
      this.drafts.forget();
      this.desk.proceed(visit);
    });
    if (!this.desk.api) for (const control of [done, giveBack, this.text]) control.disabled = true;
    this.speak.addEventListener('click', () => (this.speech?.listening ? this.speech.stop() : this.speech?.begin()));
    panel.append(
      make('h2', {}, 'Walk the path'), tour.element,
      make('p', { class: 'note' }, 'From the green pole to the red one, by the blue discs or the buttons. Where you look, and when, is recorded.'),
      make('h2', {}, make('label', { for: 'directions' }, 'Say it as you go')),
      make('p', { class: 'note' }, this.speech ? 'Type, or press Speak and talk: the browser writes it down, and you may correct it.' : 'Type while you walk. This browser cannot write down speech.'),
      ...(this.speech ? [make('p', {}, this.speak)] : []),
      this.text, this.refusal, make('p', { class: 'note beneath' }, this.count, ' ', this.draftSaid), make('p', { class: 'buttons' }, done, giveBack), this.said);
    return panel;
  }

  private resume(draft: Draft | undefined): void {
    if (draft) {
      this.text.value = draft.text;
      this.words = [...draft.words];
      this.pasted = draft.pasted;
      this.spoken = draft.spoken;
      this.draftSaid.textContent = 'Your draft is back.';
    }
    this.showCount();
  }

  private get draft(): Draft {
    return { text: this.text.value, words: this.words, steps: this.walked(), pasted: this.pasted, spoken: this.spoken };
  }

  private walked(): Entry[] {
    return this.recorder.entries().map(rounded);
  }

  private moved(): void {
    const arrived = this.viewer.pose.viewpoint === this.goal;
    this.recorder.see(this.here, this.viewer.pose);
    if (!this.desk.api) return;
    if (arrived && !this.arrived) this.refuse();
    this.arrived ||= arrived;
    const { steps } = this.recorder;
    if (steps === this.steps) return this.drafts.stir(() => this.draft);
    this.steps = steps;
    this.drafts.change(this.draft);
  }

  private typed(since?: number): void {
    this.words = retimed(this.words, this.text.value, this.recorder.seconds, since);
    this.showCount();
    if (!tooShort(this.text.value)) this.refuse();
    this.drafts.change(this.draft);
  }

  private hear(text: string, since: number): void {
    if (text === '') return;
    this.spoken = true;
    const before = this.text.value.trimEnd();
    this.text.value = `${before}${before === '' ? '' : ' '}${text}`.slice(0, mostCharacters);
    this.typed(since);
  }

  private listening(problem?: string): void {
    const { listening } = this.speech!;
    this.speak.textContent = listening ? 'Stop speaking' : 'Speak';
    this.speak.ariaPressed = String(listening);
    if (problem) this.said.replaceChildren(make('p', { class: 'problem', role: 'alert' }, `Your browser cannot listen (${problem}). Type instead.`));
  }

  private showCount(): void {
    this.count.textContent = `${counted(wordsIn(this.text.value), 'word')}.`;
  }

  private refuse(...reasons: string[]): void {
    this.text.setAttribute('aria-invalid', String(reasons.length > 0));
    this.refusal.replaceChildren(...reasons.map((reason) => make('p', { class: 'problem' }, reason)));
    if (reasons.length > 0) this.text.focus();
  }

  private async submit(): Promise<void> {
    this.speech?.stop();
    const text = this.text.value.trim();
    const reasons = [tooShort(text), this.arrived ? undefined : 'Walk the path to its end, the red pole, first.'].filter((reason) => reason !== undefined);
    this.refuse(...reasons);
    if (reasons.length > 0) return;
    this.text.readOnly = true;
    try {
      const words = retimed(this.words, text, this.recorder.seconds).map(({ word, start, end }) => ({ word, start: short(start), end: short(Math.max(start, end)) }));
      await submit(this.desk, this.drafts, {
        instruction: text, words, steps: this.walked(), spoken: this.spoken,
        seconds: Math.round(this.recorder.seconds), flags: this.pasted >= muchPasted ? ['pasted'] : [],
      }, () => say(this.draftSaid, draftTexts.here));
    } catch (error) {
      if (!(error instanceof ServerError) || error.status !== 422) throw error;
      this.refuse(...sentences(error));
    } finally {
      this.text.readOnly = false;
    }
  }
}
