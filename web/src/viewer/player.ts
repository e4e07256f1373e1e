/** Buttons of a fly-through: play, pause, again, speed, and a slider of its time. */
import { passSilence } from '../server/api.ts';
import { Flight, type Timeline } from './flight.ts';
import type { Viewer } from './viewer.ts';

const speeds = [0.5, 1, 2, 4];

export class Player {
  readonly element = document.createElement('div');
  private readonly viewer: Viewer;
  private readonly flight: Timeline;
  private readonly told: ((seconds: number) => void) | undefined;
  private readonly play = document.createElement('button');
  private readonly slider = document.createElement('input');
  private readonly speed = document.createElement('select');
  private seconds = 0;
  private running = false;
  private readonly ends = new AbortController();

  /**
   * @param what viewpoints, each next to the one before, along which a flight begins with the pose's look; or any timeline
   * @param told is called with the time whenever it changes
   */
  constructor(viewer: Viewer, what: readonly number[] | Timeline, told?: (seconds: number) => void) {
    this.viewer = viewer;
    this.flight = 'at' in what && !Array.isArray(what) ? what as Timeline : viewer.flight(what as readonly number[]);
    this.told = told;
    this.element.className = 'enfilade-player';
    this.element.setAttribute('role', 'group');
    this.element.setAttribute('aria-label', 'Fly-through of the path');
    this.play.type = 'button';
    this.play.addEventListener('click', () => (this.running ? this.pause() : this.start()));
    this.slider.type = 'range';
    this.slider.max = String(this.flight.seconds);
    this.slider.step = 'any';
    this.slider.value = '0';
    this.slider.setAttribute('aria-label', 'Time in the fly-through');
    this.slider.addEventListener('input', () => {
      this.pause();
      this.seek(Number(this.slider.value)).catch(passSilence);
    });
    this.speed.setAttribute('aria-label', 'Speed');
    for (const value of speeds) this.speed.add(new Option(`${value}×`, String(value)));
    this.speed.value = '1';
    this.element.append(this.play, this.slider, this.speed);
    // People who turn the view themselves want to look, not to be carried on. On the whole screen these buttons are in it.
    const { signal } = this.ends;
    const stop = (event: Event) => { if (!this.element.contains(event.target as Node)) this.pause(); };
    for (const event of ['pointerdown', 'keydown']) viewer.element.addEventListener(event, stop, { signal });
    this.label();
  }

  dispose(): void {
    this.pause();
    this.ends.abort();
    this.element.remove();
  }

  get playing(): boolean {
    return this.running;
  }

  start(): void {
    if (this.running) return;
    if (this.seconds >= this.flight.seconds) this.seconds = 0;
    this.running = true;
    this.label();
    this.run().catch((error: unknown) => {
      this.pause(); // else the button would say that it plays
      passSilence(error);
    });
  }

  pause(): void {
    if (!this.running) return;
    this.running = false;
    this.label();
  }

  async seek(seconds: number): Promise<void> {
    this.seconds = Math.min(Math.max(seconds, 0), this.flight.seconds);
    this.slider.value = String(this.seconds);
    this.told?.(this.seconds);
    await this.viewer.showMoment(this.flight.at(this.seconds));
  }

  private async run(): Promise<void> {
    let before = performance.now();
    while (this.running) {
      const now = await new Promise<number>((resolve) => requestAnimationFrame(resolve));
      // A picture that took long to come doesn't make the walk jump.
      const passed = Math.min(Math.max(now - before, 0) / 1000, 0.1);
      await this.seek(this.seconds + passed * Number(this.speed.value));
      before = now;
      if (this.seconds < this.flight.seconds) continue;
      if (this.flight instanceof Flight) await this.viewer.settle(); // recorded looks end as they were
      if (this.seconds >= this.flight.seconds) this.pause();
      return;
    }
  }

  private label(): void {
    const again = this.seconds >= this.flight.seconds && this.seconds > 0;
    this.play.textContent = this.running ? 'Pause' : again ? 'Replay' : 'Play';
  }
}
