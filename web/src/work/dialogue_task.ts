/** Two people: the navigator walks and asks, the oracle sees the way and answers. Each at a page of their own. */
import type { Role, Turn } from '../collecting/collections.ts';
import { action, form, labelled, twice } from '../elements/forms.ts';
import { wrapHeading } from '../geometry/geometry.ts';
import { make, say } from '../elements/page.ts';
import { api as site } from '../server/api.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { keyHelp } from '../viewer/controls.ts';
import { agentRules, MiniMap, Outlines, Viewer } from '../viewer/enfilade-viewer.ts';
import { turnHint } from '../viewer/turn_hint.ts';
import { type Desk, taskPanel } from './flow.ts';
import { explainLoss, isOutOfReach, troubles } from './refusals.ts';
import { outlinesIn } from './targets.ts';
import type { Act, Dialogue } from './visit.ts';

/** How often the server is asked what is new. */
const pauseMs = 1000;
const retryMs = 5000;
const names: Record<Role, string> = { navigator: 'Navigator', oracle: 'Oracle' };

export class DialogueTask {
  readonly viewer: Viewer;
  private readonly desk: Desk;
  private readonly role: Role;
  private readonly outlines: Outlines | undefined;
  /** For the navigator. */
  private readonly hint: HTMLElement | undefined;
  /** For the oracle. */
  private readonly map: MiniMap | undefined;
  private readonly log = make('ol', { class: 'turns', 'aria-label': 'What was said', 'aria-live': 'polite', tabindex: '0' });
  private readonly turn = make('p', { role: 'status', class: 'turn' });
  private readonly said = make('div');
  private readonly reach = make('p', { role: 'status', class: 'problem' });
  private readonly message = make('textarea', { rows: '2', maxlength: '500' });
  private readonly stop = make('div', { role: 'group', 'aria-label': 'Stop?' });
  private latest = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private queue: Promise<void> = Promise.resolve();
  private over = false;
  private at = '';
  private mine = true;
  /** Steps that the server does not have yet. */
  private pending: { viewpoint: string; heading: number; elevation: number }[] = [];

  static async open(main: HTMLElement, desk: Desk): Promise<DialogueTask> {
    const { task, api } = desk;
    const role = task.role ?? 'navigator';
    const now = api && await api.dialogue(task.task!, 0);
    const view = make('div', role === 'navigator' ? { class: 'agent' } : { class: 'view' });
    const side = make('aside', { class: 'side work', 'aria-label': 'Your task' });
    main.append(role === 'navigator' ? make('div', { class: 'view stage' }, view) : view, side);
    const { viewpoint, heading, elevation } = now?.here ?? { viewpoint: task.start!, heading: task.heading, elevation: 0 };
    const viewer = await Viewer.open(view, { scan: task.scan, viewpoint, heading, elevation, ...(role === 'navigator' && { rules: agentRules }) });
    const shown = new DialogueTask(desk, viewer, role);
    side.append(...(shown.map ? [make('div', { class: 'map' }, shown.map.element)] : []), shown.panel());
    if (now) shown.follow(now);
    return shown;
  }

  private constructor(desk: Desk, viewer: Viewer, role: Role) {
    this.desk = desk;
    this.viewer = viewer;
    this.role = role;
    this.at = this.here;
    const { object } = desk.task;
    this.outlines = object && new Outlines(viewer, outlinesIn(viewer.scan, object));
    if (role === 'oracle') {
      this.map = new MiniMap(viewer);
      void this.map.loadPlan(site, false); // as where paths are described
      return;
    }
    viewer.onChange(() => this.moved());
    this.hint = turnHint(viewer);
    viewer.element.parentElement!.append(this.hint);
  }

  save(): Promise<void> {
    return this.queue;
  }

  dispose(): void {
    this.over = true;
    clearTimeout(this.timer);
    this.outlines?.dispose();
    this.map?.dispose();
    this.viewer.dispose();
  }

  private get here(): string {
    return this.viewer.scan.viewpoints[this.viewer.pose.viewpoint]!.id;
  }

  private get pose(): { viewpoint: string; heading: number; elevation: number } {
    const { heading, elevation } = this.viewer.pose;
    return { viewpoint: this.here, heading: wrapHeading(Number(heading.toFixed(4))), elevation: Number(elevation.toFixed(4)) };
  }

  private panel(): HTMLElement {
    const navigator = this.role === 'navigator';
    const panel = taskPanel(this.desk);
    const { target = '', api } = { ...this.desk.task, api: this.desk.api };
    const about = navigator
      ? [make('h2', {}, 'You are the navigator'), make('p', { class: 'instruction' }, 'Find this: ', make('strong', {}, target)),
        make('p', {}, 'Walk by the rings on the floor. Ask the oracle, who sees the way. Stop where it is.')]
      : [make('h2', {}, 'You are the oracle'), make('p', { class: 'instruction' }, 'The navigator looks for: ', make('strong', {}, target)),
        make('p', {}, 'You see where the navigator stands, and the next steps of the way as blue discs. Answer in words.'),
        ...(this.outlines ? [make('div', { class: 'buttons' }, this.outlines.said, this.outlines.button)] : [])];
    const [box] = labelled('message', navigator ? 'Your question' : 'Your answer', this.message);
    const talk = form('Send', [box], () => this.send());
    this.message.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || event.shiftKey || event.isComposing) return;
      event.preventDefault();
      talk.requestSubmit();
    });
    const leave = twice('Leave this dialogue', 'Leave? Another worker takes your seat', this.said, async () => {
      this.over = true;
      this.desk.proceed(await this.desk.api!.giveBack(this.desk.task.task!));
    });
    if (!api) for (const control of [this.message, leave, talk.querySelector('button')!]) control.disabled = true;
    this.ask(false);
    panel.append(...about, this.turn, this.log, talk, ...(navigator && api ? [this.stop] : []), make('p', {}, leave), this.said, this.reach,
      ...(navigator ? [make('p', { class: 'note' }, make('span', { class: 'keys' }, keyHelp(this.viewer)))] : []));
    return panel;
  }

  /** Stopping ends the dialogue for both, so it takes two presses. */
  private ask(sure: boolean): void {
    if (!sure) {
      const stop = make('button', { type: 'button', id: 'stop' }, 'Stop here: this is the place');
      stop.addEventListener('click', () => this.ask(true));
      return this.stop.replaceChildren(make('p', {}, stop));
    }
    const yes = action('Yes, I am there', this.said, () => this.act({ stop: true }), { class: 'main' });
    const no = make('button', { type: 'button' }, 'Go on');
    no.addEventListener('click', () => {
      this.ask(false);
      document.getElementById('stop')?.focus();
    });
    this.stop.replaceChildren(make('p', {}, 'The dialogue ends for both of you. Is this the place?'), make('p', { class: 'buttons' }, yes, no));
    yes.focus();
  }

  private async send(): Promise<void> {
    const text = this.message.value.trim();
    if (text === '') return this.message.focus();
    if (!this.mine) throw new Error(`It is the ${names[this.other].toLowerCase()}'s turn: wait for the answer.`);
    // The oracle wants to know where one looks.
    if (this.role === 'navigator') {
      this.pending.push(this.pose);
      // A step after the question would come when it is the oracle's turn.
      this.viewer.confine([this.viewer.pose.viewpoint]);
    }
    try {
      await this.act({ say: text });
    } catch (error) {
      if (this.role === 'navigator') this.hold();
      throw error;
    }
    this.message.value = '';
    this.message.focus();
  }

  private get other(): Role {
    return this.role === 'navigator' ? 'oracle' : 'navigator';
  }

  private moved(): void {
    if (!this.desk.api || this.here === this.at) return;
    this.at = this.here;
    this.pending.push(this.pose);
    this.ask(false);
    void this.soon(0);
  }

  /** One after another, steps first: the server checks each against the one before. */
  private act(act: Act): Promise<void> {
    const done = this.queue.then(async () => {
      await this.sendSteps();
      this.follow(await this.desk.api!.act(this.desk.task.task!, act, this.latest));
    });
    this.queue = done.catch(() => {});
    return done.catch((error: unknown) => { throw explainLoss(error); });
  }

  private async sendSteps(): Promise<void> {
    const steps = this.pending;
    if (steps.length === 0) return;
    const now = await this.desk.api!.act(this.desk.task.task!, { steps }, this.latest);
    this.pending = this.pending.slice(steps.length);
    this.follow(now);
  }

  /** Sends what is to be sent, and asks what is new. */
  private soon(ms: number): void {
    clearTimeout(this.timer);
    if (this.over) return;
    this.timer = setTimeout(() => {
      this.queue = this.queue.then(() => this.sendSteps())
        .then(async () => this.follow(await this.desk.api!.dialogue(this.desk.task.task!, this.latest)))
        .catch((error: unknown) => this.fail(error));
    }, ms);
  }

  private fail(error: unknown): void {
    if (this.over) return;
    if (isOutOfReach(error)) {
      say(this.reach, 'The server is out of reach; we try again.');
      return this.soon(retryMs);
    }
    this.over = true;
    this.said.replaceChildren(troubles(explainLoss(error)));
  }

  private follow(now: Dialogue): void {
    if (this.over) return;
    say(this.reach, '');
    for (const turn of now.turns) this.add(turn);
    if (now.finished) {
      this.over = true;
      clearTimeout(this.timer);
      void this.desk.api!.visit().then((visit) => this.desk.proceed(visit), (error: unknown) => this.said.replaceChildren(troubles(error)));
      return;
    }
    this.mine = now.turn === this.role;
    say(this.turn, this.turnText(now));
    if (this.role === 'navigator') this.hold();
    else void this.watch(now);
    this.soon(pauseMs);
  }

  private turnText({ partner, arrived }: Dialogue): string {
    if (!partner) return `There is no ${names[this.other].toLowerCase()} now. Stay: the next worker who comes takes that seat.`;
    const there = arrived ? ' The navigator is at the goal.' : '';
    if (this.role === 'oracle') return (this.mine ? 'It is your turn: answer.' : 'The navigator walks. Wait for a question.') + there;
    return this.mine ? 'It is your turn: walk, or ask.' : 'The oracle answers. Wait here.';
  }

  private add({ turn = 0, role, text }: Turn): void {
    if (turn <= this.latest) return;
    this.latest = turn;
    if (text === undefined) return;
    this.log.append(make('li', { class: role }, make('strong', {}, `${role === this.role ? 'You' : names[role]}: `), text));
    this.log.scrollTop = this.log.scrollHeight;
  }

  /** Who waits for an answer stays. */
  private hold(): void {
    const held = this.viewer.pose.viewpoint;
    this.viewer.confine(this.mine ? this.viewer.scan.viewpoints.keys() : [held]);
    this.hint!.hidden = !this.mine; // one waits
  }

  /** The oracle stands where the navigator stands, and sees the way. */
  private async watch({ here, ahead = [] }: Dialogue): Promise<void> {
    const key = [here.viewpoint, here.heading, here.elevation, ...ahead].join();
    if (key === this.watched) return;
    this.watched = key;
    const viewpoint = viewpointIndex(this.viewer.scan, here.viewpoint);
    this.viewer.confine([viewpoint]);
    const way = ahead.map((id) => viewpointIndex(this.viewer.scan, id));
    this.viewer.setPath(way);
    this.map?.setPath(way);
    await this.viewer.jump({ viewpoint, heading: here.heading, elevation: here.elevation });
  }
  private watched = '';
}
