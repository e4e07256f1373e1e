/** Following an instruction: one sees and does what an agent of R2R may, until one stops. */
import type { Entry } from '../collecting/collections.ts';
import { action } from '../elements/forms.ts';
import { wrapHeading } from '../geometry/geometry.ts';
import { make, say } from '../elements/page.ts';
import { keyHelp } from '../viewer/controls.ts';
import { agentRules, Viewer } from '../viewer/enfilade-viewer.ts';
import { turnHint } from '../viewer/turn_hint.ts';
import { type DraftState, Drafts } from './drafts.ts';
import { type Desk, submit, taskPanel } from './flow.ts';
import { Recorder } from './recorder.ts';
import { lostText } from './refusals.ts';
import { outOfReachText, storage } from './storage.ts';

interface Draft {
  readonly steps: readonly Entry[];
}

const draftTexts: Record<DraftState, string> = {
  saving: '', saved: '',
  here: outOfReachText('walk'),
  lost: lostText,
};

/** Small in the database, and a heading below a whole turn stays below it. */
export function rounded(entry: Entry): Entry {
  const cut = (x: number, unit: number) => Math.floor(x / unit) * unit;
  const short = (x: number) => Number(cut(x, 1e-5).toFixed(5));
  return { ...entry, heading: wrapHeading(short(entry.heading)), elevation: short(entry.elevation), seconds: Number(cut(entry.seconds, 0.01).toFixed(2)) };
}

export class WalkTask {
  readonly viewer: Viewer;
  protected readonly desk: Desk;
  private readonly recorder: Recorder;
  private readonly drafts: Drafts<Draft>;
  private readonly draftSaid = make('p', { role: 'status', class: 'problem' });
  protected readonly said = make('div');
  protected readonly sure = make('div', { role: 'group', 'aria-label': 'Stop?' });
  protected readonly stop = make('button', { type: 'button', class: 'main' }, 'Stop here');
  private steps = 0;

  static async open(main: HTMLElement, desk: Desk): Promise<WalkTask> {
    const { task, api } = desk;
    const view = make('div', { class: 'agent' });
    const [stage, side] = [make('div', { class: 'view stage' }, view), make('aside', { class: 'side work', 'aria-label': 'Your task' })];
    main.append(stage, side);
    const drafts = new Drafts<Draft>(`walk/${task.task}`, storage, (draft) => api!.keepDraft(task.task!, draft));
    const draft = api && drafts.begin(task.draft as Draft | undefined);
    const { viewpoint, heading, elevation } = draft?.steps.at(-1) ?? { viewpoint: task.start!, heading: task.heading, elevation: 0 };
    const viewer = await Viewer.open(view, { scan: task.scan, rules: agentRules, viewpoint, heading, elevation });
    stage.append(turnHint(viewer));
    const walk = new this(desk, viewer, drafts, draft?.steps ?? []);
    side.append(walk.panel());
    return walk;
  }

  protected constructor(desk: Desk, viewer: Viewer, drafts: Drafts<Draft>, before: readonly Entry[]) {
    this.desk = desk;
    this.viewer = viewer;
    this.drafts = drafts;
    this.recorder = new Recorder(this.here, viewer.pose, before);
    this.steps = this.recorder.steps;
    this.sure.replaceChildren(make('p', {}, this.stop));
    drafts.onState((state) => say(this.draftSaid, draftTexts[state]));
    viewer.onChange(() => this.moved());
    this.stop.addEventListener('click', () => this.ask(true));
  }

  save(): Promise<void> {
    return this.drafts.save();
  }

  dispose(): void {
    this.drafts.dispose();
    this.viewer.dispose();
  }

  protected get here(): string {
    return this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!.id;
  }

  private panel(): HTMLElement {
    const panel = taskPanel(this.desk);
    this.stop.disabled = !this.desk.api;
    this.ask(false);
    panel.append(make('h2', {}, 'Follow this'), make('p', { class: 'instruction' }, this.desk.task.instruction ?? ''),
      this.sure, this.said, this.draftSaid,
      make('p', { class: 'note' }, 'Drag to look around, and down for what is near. Click or tap a ring on the floor to go there. ',
        make('span', { class: 'keys' }, keyHelp(this.viewer))));
    return panel;
  }

  private moved(): void {
    this.recorder.see(this.here, this.viewer.pose);
    if (!this.desk.api) return;
    const draft = (): Draft => ({ steps: this.walked() });
    const { steps } = this.recorder;
    if (steps === this.steps) return this.drafts.stir(draft);
    this.steps = steps;
    this.ask(false);
    this.drafts.change(draft());
  }

  protected walked(): Entry[] {
    return this.recorder.entries().map(rounded);
  }

  /** Stopping is for good, so it takes two presses. */
  protected ask(sure: boolean): void {
    if (!sure) {
      this.sure.replaceChildren(make('p', {}, this.stop));
      return;
    }
    const yes = action('Yes, this is the goal', this.said, () => this.submit(), { class: 'main' });
    const no = make('button', { type: 'button' }, 'Keep walking');
    no.addEventListener('click', () => {
      this.ask(false);
      this.stop.focus();
    });
    this.sure.replaceChildren(make('p', {}, 'You cannot walk on once you have stopped. Is this the place?'),
      make('p', { class: 'buttons' }, yes, no));
    yes.focus();
  }

  /** What is sent beside the steps. */
  protected result(): object {
    return {};
  }

  protected async submit(): Promise<void> {
    const { width, height } = this.viewer.view;
    const camera = { width: Math.round(width), height: Math.round(height), vfov: this.viewer.pose.vfov };
    await submit(this.desk, this.drafts, { steps: this.walked(), camera, ...this.result() }, () => say(this.draftSaid, draftTexts.here));
  }
}
