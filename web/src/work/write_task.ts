/** Writing directions for a path, or about an object at its end: its fly-through, its places, a text. */
import { action, twice } from '../elements/forms.ts';
import { counted, make, say } from '../elements/page.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { api, ServerError } from '../server/api.ts';
import { MiniMap, Outlines, Player, Viewer } from '../viewer/enfilade-viewer.ts';
import { Drafts, type DraftState } from './drafts.ts';
import { type Desk, submit, taskPanel } from './flow.ts';
import { type Hint, hintsFor, tooShort, wordsIn } from './hints.ts';
import { Looks } from './looks.ts';
import { lostDraftText, sentences } from './refusals.ts';
import { outOfReachText, storage } from './storage.ts';
import { outlinesIn } from './targets.ts';
import { Tour } from './tour.ts';

/** What is kept of a task that is not done. */
interface Draft {
  readonly text: string;
  readonly pasted: number;
  readonly goalSeen: boolean;
  readonly seconds: number;
}

/** The server's limits, characters. */
const mostCharacters = 2000;

const draftTexts: Record<DraftState, string> = {
  saving: 'Saving…', saved: 'Draft saved.',
  here: outOfReachText('text'),
  lost: lostDraftText,
};

export class WriteTask {
  private readonly desk: Desk;
  readonly viewer: Viewer;
  private readonly map: MiniMap;
  private readonly player: Player;
  private readonly drafts: Drafts<Draft>;
  private readonly outlines: Outlines | undefined;
  private readonly looks = new Looks();
  private readonly goal: number;
  private readonly text = make('textarea', { id: 'directions', rows: '6', maxlength: String(mostCharacters), 'aria-describedby': 'refusal words' });
  private readonly refusal = make('div', { id: 'refusal', role: 'alert' });
  private readonly count = make('span', { id: 'words' });
  private readonly draftSaid = make('span', { role: 'status' });
  private readonly advice = make('div', { role: 'status' });
  private readonly row = make('p', { class: 'buttons' });
  private readonly said = make('div');
  private readonly begin = performance.now();
  private pasted = 0;
  private goalSeen = false;
  private secondsBefore = 0;
  private advised = '';

  static async open(main: HTMLElement, desk: Desk): Promise<WriteTask> {
    const { scan, path = [] } = desk.task;
    const [view, side] = [make('div', { class: 'view' }), make('aside', { class: 'side work', 'aria-label': 'Your task' })];
    main.append(view, side);
    // Towards the second viewpoint: a start's heading is random, and often shows a wall.
    const viewer = await Viewer.open(view, { scan, viewpoint: path[0]!, ...(path[1] !== undefined && { towards: path[1] }) });
    return new WriteTask(desk, viewer, side);
  }

  private constructor(desk: Desk, viewer: Viewer, side: HTMLElement) {
    this.desk = desk;
    this.viewer = viewer;
    const path = desk.task.path!.map((id) => viewpointIndex(viewer.scan, id));
    this.goal = path.at(-1)!;
    viewer.setPath(path);
    viewer.confine(path);
    const { object } = desk.task;
    this.outlines = object && new Outlines(viewer, outlinesIn(viewer.scan, object));
    this.map = new MiniMap(viewer);
    this.map.setPath(path);
    void this.map.loadPlan(api, false); // workers would copy the names
    this.player = new Player(viewer, path);
    const tour = new Tour(viewer, path, this.looks, () => this.player.pause(), () => this.outlines?.lookAt());
    const { task = 0 } = desk.task;
    this.drafts = new Drafts(`write/${task}`, storage, (draft) => desk.api!.keepDraft(task, draft));
    this.drafts.onState((state) => say(this.draftSaid, draftTexts[state]));
    side.append(make('div', { class: 'map' }, this.map.element), this.panel(tour));
    viewer.onChange(() => this.looked());
    this.listen();
    this.resume();
  }

  save(): Promise<void> {
    return this.drafts.save();
  }

  dispose(): void {
    this.drafts.dispose();
    this.player.dispose();
    this.map.dispose();
    this.outlines?.dispose();
    this.viewer.dispose();
  }

  private panel(tour: Tour): HTMLElement {
    const panel = taskPanel(this.desk);
    const { object } = this.desk.task;
    panel.append(
      make('h2', {}, 'See the path'), this.player.element, tour.element,
      ...(object ? [make('h2', {}, 'The object'), make('p', {}, 'With an orange frame at the end of the path: ', make('strong', {}, object.name), '.'),
        make('div', { class: 'buttons' }, this.outlines!.said, this.outlines!.button)] : []),
      make('h2', {}, make('label', { for: 'directions' }, object ? 'Your request' : 'Your directions')),
      make('p', { class: 'note' }, object ? 'Write to a person at the green pole who should find this very object.' : 'From the start, the green pole, to the goal, the red one.'),
      this.text, this.refusal, make('p', { class: 'note beneath' }, this.count, ' ', this.draftSaid), this.advice, this.buttons(), this.said);
    return panel;
  }

  private buttons(): HTMLElement {
    const done = action('Submit', this.said, () => this.submit(), { class: 'main' });
    const giveBack = twice(this.desk.task.object ? 'Skip this object' : 'Skip this path', 'Skip it? You will not be offered it again', this.said, async () => {
      const visit = await this.desk.api!.giveBack(this.desk.task.task!);
      this.drafts.forget();
      this.desk.proceed(visit);
    });
    if (!this.desk.api) for (const button of [done, giveBack]) button.disabled = true;
    this.text.disabled = !this.desk.api;
    this.row.append(done, giveBack);
    return this.row;
  }

  private listen(): void {
    this.text.addEventListener('input', () => this.changed());
    this.text.addEventListener('paste', (event) => {
      this.pasted += event.clipboardData?.getData('text').length ?? 0;
    });
  }

  private resume(): void {
    const draft = this.desk.api && this.drafts.begin(this.desk.task.draft as Draft | undefined);
    if (draft) {
      this.text.value = draft.text ?? '';
      this.pasted = draft.pasted ?? 0;
      this.goalSeen = draft.goalSeen ?? false;
      this.secondsBefore = draft.seconds ?? 0;
      this.draftSaid.textContent = 'Your draft is back.';
    }
    this.showCount();
  }

  private get draft(): Draft {
    return { text: this.text.value, pasted: this.pasted, goalSeen: this.goalSeen, seconds: this.seconds };
  }

  private get seconds(): number {
    return Math.round(this.secondsBefore + (performance.now() - this.begin) / 1000);
  }

  private looked(): void {
    if (this.desk.api) this.drafts.stir(() => this.draft);
    if (this.player.playing) return;
    const { pose } = this.viewer;
    this.looks.see(pose.viewpoint, pose);
    this.goalSeen ||= this.looks.around(this.goal);
  }

  private changed(): void {
    this.showCount();
    this.drafts.change(this.draft);
    if (!tooShort(this.text.value)) this.refuse();
    if (this.advised) this.advise(hintsFor(this.text.value, this.draft));
  }

  private showCount(): void {
    const words = wordsIn(this.text.value);
    this.count.textContent = `${counted(words, 'word')}.`;
  }

  private advise(hints: readonly Hint[]): void {
    const key = hints.map(({ code }) => code).join();
    if (key === this.advised) return;
    this.advised = key;
    this.advice.replaceChildren(...(hints.length === 0 ? [] : [
      make('div', { class: 'notice' }, make('ul', {}, ...hints.map(({ text }) => make('li', {}, text))),
        make('p', {}, 'If it is right as it is, submit it again.'))]));
  }

  /** Says beside the text why it is not taken; nothing: it may be. */
  private refuse(...reasons: string[]): void {
    this.text.setAttribute('aria-invalid', String(reasons.length > 0));
    this.refusal.replaceChildren(...reasons.map((reason) => make('p', { class: 'problem' }, reason)));
    if (reasons.length === 0) return;
    this.text.focus();
    this.text.scrollIntoView({ block: 'center' });
  }

  /** The first time with advice, if there is any; what was advised once does not stand in the way again. */
  private async submit(): Promise<void> {
    const text = this.text.value.trim();
    const short = tooShort(text);
    this.refuse(...(short ? [short] : []));
    if (short) return this.advise([]);
    const before = this.advised.split(',');
    const hints = hintsFor(text, this.draft);
    const flags = hints.map(({ code }) => code);
    this.advise(hints);
    this.row.scrollIntoView({ block: 'nearest' }); // advice pushed it down
    if (flags.some((flag) => !before.includes(flag))) return;
    this.text.readOnly = true; // what is sent is what stands there
    try {
      await submit(this.desk, this.drafts, { instruction: text, seconds: this.seconds, flags },
        () => say(this.draftSaid, draftTexts.here));
    } catch (error) {
      if (!(error instanceof ServerError) || error.status !== 422) throw error;
      this.refuse(...sentences(error));
    } finally {
      this.text.readOnly = false;
    }
  }
}
