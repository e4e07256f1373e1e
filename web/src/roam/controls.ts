/** Keys, mouse and touch: for walking, and for the building from outside. */
import { degrees } from '../geometry/geometry.ts';
import type { FloorPoint } from './floor.ts';
import type { RoamView } from './roam_view.ts';
import type { Action, Walker } from './walker.ts';

/** Smooth walking, as people stroll indoors: metres and radians per second. */
const speed = 1.3;
const turning = degrees(90);
/** To a place that was clicked on one goes faster. */
const hurry = 2;
const arrived = 0.02;
const orbitStep = degrees(15);
/** Of a drag from outside: radians a pixel. */
const orbitPixel = 0.008;
const zoomStep = 1.1;
const clickSlack = 6;

export const keyHelp = 'Arrow keys act as an agent does: ↑ a step of 0.25 m, ← and → a turn of 15°. '
  + 'W, A, S and D walk smoothly, Q and E turn, Page Up and Page Down look up and down.';
export const mouseHelp = 'Drag to look around. A click on the floor goes there.';
export const houseHelp = 'Arrow keys turn the building, plus and minus zoom.';

const stepKeys: Readonly<Record<string, Action>> = { ArrowUp: 'forward', ArrowLeft: 'left', ArrowRight: 'right', PageUp: 'up', PageDown: 'down' };
/** Ahead, to the right, turning to the right. */
const freeKeys: Readonly<Record<string, readonly [number, number, number]>> = {
  KeyW: [1, 0, 0], KeyS: [-1, 0, 0], KeyA: [0, -1, 0], KeyD: [0, 1, 0], KeyQ: [0, 0, -1], KeyE: [0, 0, 1],
};

/** What a page does with them. */
interface Handlers {
  /** An agent's action was done. */
  acted(action: Action, touched: boolean): void;
  /** The place on the floor that a point of the canvas, in pixels, stands for. */
  floorAt(x: number, y: number): FloorPoint | undefined;
  /** A click on the floor of the doll's house. */
  chose(at: FloorPoint): void;
}

export class RoamControls {
  private readonly view: RoamView;
  private readonly walker: Walker;
  private readonly handlers: Handlers;
  private readonly held = new Set<string>();
  private readonly pointers = new Map<number, { readonly x: number; readonly y: number }>();
  private readonly ring = document.createElement('div');
  private goal: FloorPoint | undefined;
  private moved = 0;
  private before = 0;
  private frame = 0;

  constructor(view: RoamView, walker: Walker, handlers: Handlers) {
    [this.view, this.walker, this.handlers] = [view, walker, handlers];
    this.ring.className = 'roam-ring';
    this.ring.hidden = true;
    this.ring.ariaHidden = 'true';
    view.element.append(this.ring);
    const { canvas } = view;
    canvas.setAttribute('role', 'application');
    canvas.addEventListener('keydown', (event) => this.press(event));
    canvas.addEventListener('keyup', (event) => this.held.delete(event.code));
    canvas.addEventListener('blur', () => this.held.clear());
    canvas.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return; // the others have menus of their own
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.ring.hidden = true;
      this.moved = this.pointers.size > 1 ? Infinity : 0;
    });
    canvas.addEventListener('pointermove', (event) => this.drag(event));
    canvas.addEventListener('pointerup', (event) => this.release(event));
    canvas.addEventListener('pointercancel', (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener('pointerleave', () => (this.ring.hidden = true));
    canvas.addEventListener('wheel', (event) => {
      if (this.view.mode !== 'house' || this.view.flying) return;
      event.preventDefault();
      this.ring.hidden = true; // until the mouse is moved again
      this.view.zoomBy(zoomStep ** Math.sign(event.deltaY));
    }, { passive: false });
    this.name();
  }

  /** Says what the keys do now. */
  name(): void {
    const text = this.view.mode === 'inside' ? `The building from within. ${keyHelp}` : `Doll’s house. ${houseHelp}`;
    this.view.canvas.setAttribute('aria-label', text);
  }

  /** Ends the way to a place that was clicked on. */
  halt(): void {
    this.goal = undefined;
  }

  act(action: Action): void {
    this.halt();
    this.handlers.acted(action, this.walker.act(action));
  }

  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey || this.view.flying) return;
    this.ring.hidden = true;
    if (this.view.mode === 'house') return this.pressOutside(event);
    const step = stepKeys[event.key];
    if (step) this.act(step);
    else if (freeKeys[event.code]) this.hold(event.code);
    else if (event.key !== 'ArrowDown') return; // an agent cannot go backwards; the page is not to scroll either
    event.preventDefault();
  }

  private pressOutside(event: KeyboardEvent): void {
    const actions: Record<string, () => void> = {
      ArrowLeft: () => this.view.orbit(-orbitStep, 0), ArrowRight: () => this.view.orbit(orbitStep, 0),
      ArrowUp: () => this.view.orbit(0, orbitStep), ArrowDown: () => this.view.orbit(0, -orbitStep),
      '+': () => this.view.zoomBy(1 / zoomStep), '=': () => this.view.zoomBy(1 / zoomStep), '-': () => this.view.zoomBy(zoomStep),
    };
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  private hold(code: string): void {
    this.held.add(code);
    this.halt();
    this.begin();
  }

  /** Straight to a place on the floor, or as far as a wall lets one. */
  private walkTo(goal: FloorPoint): void {
    this.goal = goal;
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) while (this.goal) this.near(0.25);
    else this.begin();
  }

  /** Goes nearer to the goal by these metres. No goal is left when it is reached, or a wall is. */
  private near(metres: number): void {
    const [x, y] = this.goal!.position;
    const [dx, dy] = [x - this.walker.position[0], y - this.walker.position[1]];
    const away = Math.hypot(dx, dy);
    if (away < arrived) return this.halt();
    const [s, c, part] = [Math.sin(this.walker.heading), Math.cos(this.walker.heading), Math.min(metres / away, 1)];
    if (this.walker.glide((dx * s + dy * c) * part, (dx * c - dy * s) * part)) this.halt();
  }

  private begin(): void {
    if (this.frame !== 0) return;
    this.before = performance.now();
    this.frame = requestAnimationFrame((now) => this.stroll(now));
  }

  private stroll(now: number): void {
    this.frame = 0;
    if (this.view.mode !== 'inside') this.halt();
    if ((this.held.size === 0 && !this.goal) || this.view.mode !== 'inside') return;
    const seconds = Math.min(Math.max((now - this.before) / 1000, 0), 0.15); // no leap after a pause
    this.before = now;
    let [ahead, right, turn] = [0, 0, 0];
    for (const code of this.held) {
      const [a, r, t] = freeKeys[code]!;
      [ahead, right, turn] = [ahead + a, right + r, turn + t];
    }
    if (turn !== 0) this.walker.look(this.walker.heading + turn * turning * seconds, this.walker.elevation);
    const size = Math.hypot(ahead, right);
    if (size > 0) this.walker.glide((ahead / size) * speed * seconds, (right / size) * speed * seconds);
    if (this.goal) this.near(hurry * speed * seconds);
    this.frame = requestAnimationFrame((next) => this.stroll(next));
  }

  private drag(event: PointerEvent): void {
    const before = this.pointers.get(event.pointerId);
    if (!before || this.view.flying) return this.hover(event);
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    const now = { x: event.clientX, y: event.clientY };
    if (this.pointers.size > 1) this.pinch(event.pointerId, before, now);
    else if (this.view.mode === 'house') this.view.orbit(dx * orbitPixel, dy * orbitPixel);
    else this.walker.look(this.walker.heading - dx * this.view.perPixel, this.walker.elevation + dy * this.view.perPixel);
    this.moved += Math.hypot(dx, dy);
    this.pointers.set(event.pointerId, now);
  }

  private pinch(id: number, before: { x: number; y: number }, now: { x: number; y: number }): void {
    if (this.view.mode !== 'house') return;
    const other = [...this.pointers].find(([one]) => one !== id)![1];
    const apart = (p: { x: number; y: number }) => Math.max(Math.hypot(p.x - other.x, p.y - other.y), 1);
    this.view.zoomBy(apart(before) / apart(now));
  }

  private release(event: PointerEvent): void {
    if (!this.pointers.delete(event.pointerId) || this.moved > clickSlack || this.view.flying) return;
    const at = this.at(event);
    if (!at) return;
    if (this.view.mode === 'house') this.handlers.chose(at);
    else this.walkTo(at);
  }

  private at(event: PointerEvent): FloorPoint | undefined {
    const box = this.view.canvas.getBoundingClientRect();
    return this.handlers.floorAt(event.clientX - box.left, event.clientY - box.top);
  }

  /** A ring lies on the floor where a click would take one. */
  private hover(event: PointerEvent): void {
    if (event.pointerType !== 'mouse' || event.buttons !== 0) return;
    const at = this.view.flying ? undefined : this.at(event);
    const ring = at && this.view.ringAt(at.position);
    this.ring.hidden = !ring;
    this.view.canvas.classList.toggle('lands', ring !== undefined);
    if (!ring) return;
    this.ring.style.transform = `translate(${ring.x}px, ${ring.y}px) scale(${ring.wide / 200}, ${ring.high / 200})`;
  }
}
