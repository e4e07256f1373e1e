/** The building from outside, without its roof: made of its plan's rooms. */
import * as three from 'three';
import { degrees } from '../geometry/geometry.ts';
import { pictured, type Plan, type Room, roomCentre, storeyOf } from '../scan/scan.ts';
import { pointsOf, things, wallsOf } from './house_shape.ts';
import type { Viewer } from './viewer.ts';

/** Metres, where a scan doesn't say. */
const usualHeight = 2.5;
const furnitureHeight = 0.5;
/** Floors by the room's name: alike rooms look alike, and none is as light as the walls. */
const floorColours = [0xc8a878, 0xa9b7a0, 0xb7a9c0, 0x9fb4c4, 0xc4a59a, 0xbdb58f, 0x9dbab2, 0xb3a18d];
const wallColour = 0xf3f0ea;
const chosenColour = 0xffc46b;
const keyTurn = degrees(15);
const clickSlack = 6;

const colourOf = (name: string): number => {
  let sum = 7;
  for (const letter of name) sum = (sum * 31 + letter.charCodeAt(0)) % 9973;
  return floorColours[sum % floorColours.length]!;
};

/** Turned by dragging and by the arrow keys; a click on a room goes there. */
export class DollsHouse {
  readonly element = document.createElement('div');
  private readonly viewer: Viewer;
  private readonly plan: Plan;
  private readonly renderer = new three.WebGLRenderer({ antialias: true, alpha: true });
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(35, 1, 0.1, 500);
  private readonly storeys: three.Group[] = [];
  private readonly floors = new Map<three.Mesh<three.ShapeGeometry, three.MeshLambertMaterial>, Room>();
  private readonly you = new three.Group();
  private readonly label = document.createElement('div');
  private readonly resizes = new ResizeObserver(() => this.draw());
  private readonly middle = new three.Vector3();
  private reach = 10;
  private azimuth = degrees(25);
  private height = degrees(52);
  private zoom = 1;
  private storey = 0;
  private grip: { x: number; y: number; moved: number } | undefined;
  private chosen: three.Mesh<three.ShapeGeometry, three.MeshLambertMaterial> | undefined;
  private frame = 0;

  /** Throws Error without WebGL. @param plan has rooms */
  constructor(viewer: Viewer, plan: Plan) {
    this.viewer = viewer;
    this.plan = plan;
    this.element.className = 'enfilade-house';
    this.label.className = 'enfilade-hint';
    this.label.hidden = true;
    this.label.ariaHidden = 'true'; // the list of rooms says it
    this.renderer.outputColorSpace = three.SRGBColorSpace;
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'application');
    canvas.setAttribute('aria-label', 'Doll’s house. Arrow keys turn it, plus and minus zoom; the list of rooms goes to them.');
    this.element.append(canvas, this.label);
    this.build();
    this.light();
    this.listen(canvas);
    this.resizes.observe(this.element);
    viewer.onChange(() => this.draw());
  }

  /** Leaves out what is above a storey. */
  showStorey(storey: number): void {
    this.storey = Math.max(storey, 0);
    this.storeys.forEach((group, k) => (group.visible = k <= this.storey));
    this.draw();
  }

  /** At the next frame. */
  draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => this.drawNow());
  }

  private build(): void {
    const box = new three.Box3();
    const wall = new three.MeshLambertMaterial({ color: wallColour });
    const glass = new three.MeshLambertMaterial({ color: 0x9cc7e6, transparent: true, opacity: 0.45 });
    const thing = new three.MeshLambertMaterial({ color: 0xd8cdbd });
    this.plan.storeys.forEach((storey, s) => {
      const group = new three.Group();
      const rooms = this.plan.rooms.filter((room) => room.storey === s && room.outline.length >= 6);
      const above = this.plan.storeys[s + 1]?.floor ?? Infinity;
      for (const room of rooms) {
        const floor = new three.Mesh(
          new three.ShapeGeometry(new three.Shape(pointsOf(room.outline).map(([x, y]) => new three.Vector2(x, y)))),
          new three.MeshLambertMaterial({ color: colourOf(room.name), side: three.DoubleSide }),
        );
        floor.position.z = room.floor;
        this.floors.set(floor, room);
        group.add(floor);
        const height = Math.min(room.height ?? usualHeight, above - room.floor - 0.1);
        for (const clear of [false, true]) {
          const parts = wallsOf(room, storey, height).filter((part) => part.glass === clear);
          const shape = quads(parts.map(({ a, b, low, high }) => [a, b, room.floor + low, room.floor + high]));
          group.add(new three.Mesh(shape, clear ? glass : wall));
        }
      }
      for (const ring of things(storey.furniture)) {
        const shape = new three.ExtrudeGeometry(new three.Shape(ring.map(([x, y]) => new three.Vector2(x, y))),
          { depth: furnitureHeight, bevelEnabled: false });
        const mesh = new three.Mesh(shape, thing);
        mesh.position.z = storey.floor;
        group.add(mesh);
      }
      this.storeys.push(group);
      this.scene.add(group);
      if (rooms.length > 0) box.expandByObject(group);
    });
    box.getCenter(this.middle);
    this.reach = box.getSize(new three.Vector3()).length() / 2;
    const mark = new three.MeshBasicMaterial({ color: 0xd97a00 });
    const ball = new three.Mesh(new three.SphereGeometry(0.22, 16, 12), mark);
    const arrow = new three.Mesh(new three.ConeGeometry(0.2, 0.7, 16), mark); // along +y, as a heading of 0
    arrow.position.y = 0.5;
    this.you.add(ball, arrow);
    this.scene.add(this.you);
  }

  private light(): void {
    this.scene.add(new three.HemisphereLight(0xffffff, 0x8f8a80, 2.2));
    const sun = new three.DirectionalLight(0xfff2dd, 1.6);
    sun.position.set(-4, -7, 10);
    this.scene.add(sun);
  }

  private listen(canvas: HTMLCanvasElement): void {
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.grip = { x: event.clientX, y: event.clientY, moved: 0 };
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!this.grip) return this.choose(this.floorAt(event), event);
      const [dx, dy] = [event.clientX - this.grip.x, event.clientY - this.grip.y];
      this.grip = { x: event.clientX, y: event.clientY, moved: this.grip.moved + Math.hypot(dx, dy) };
      this.turn(dx * 0.01, dy * 0.01);
    });
    canvas.addEventListener('pointerup', (event) => {
      const click = this.grip !== undefined && this.grip.moved <= clickSlack;
      this.grip = undefined;
      const floor = click ? this.floorAt(event) : undefined;
      if (floor) this.enter(this.floors.get(floor)!);
    });
    canvas.addEventListener('pointercancel', () => (this.grip = undefined));
    canvas.addEventListener('pointerleave', () => this.choose(undefined));
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.scale(1.1 ** Math.sign(event.deltaY));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      const actions: Record<string, () => void> = {
        ArrowLeft: () => this.turn(-keyTurn, 0), ArrowRight: () => this.turn(keyTurn, 0),
        ArrowUp: () => this.turn(0, keyTurn), ArrowDown: () => this.turn(0, -keyTurn),
        '+': () => this.scale(1 / 1.1), '=': () => this.scale(1 / 1.1), '-': () => this.scale(1.1),
      };
      const action = actions[event.key];
      if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      action();
    });
  }

  private turn(around: number, up: number): void {
    this.azimuth -= around;
    this.height = Math.min(Math.max(this.height + up, degrees(15)), degrees(89));
    this.draw();
  }

  private scale(by: number): void {
    this.zoom = Math.min(Math.max(this.zoom * by, 0.3), 2);
    this.draw();
  }

  private enter(room: Room): void {
    const { scan } = this.viewer;
    const shown = pictured(scan, room);
    if (shown.viewpoints.length > 0) void this.viewer.go(roomCentre(scan, shown), true);
  }

  private floorAt(event: PointerEvent): typeof this.chosen {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new three.Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new three.Raycaster();
    ray.setFromCamera(at, this.camera);
    const shown = [...this.floors.keys()].filter((floor) => floor.parent!.visible);
    return ray.intersectObjects(shown, false)[0]?.object as typeof this.chosen;
  }

  private choose(floor: typeof this.chosen, event?: PointerEvent): void {
    if (floor !== this.chosen) {
      this.chosen?.material.color.setHex(colourOf(this.floors.get(this.chosen)!.name));
      floor?.material.color.setHex(chosenColour);
      this.chosen = floor;
      this.draw();
    }
    const name = floor ? this.floors.get(floor)!.name : '';
    this.label.hidden = name === '';
    this.label.textContent = name;
    if (!event) return;
    const box = this.element.getBoundingClientRect();
    this.label.style.left = `${event.clientX - box.left}px`;
    this.label.style.top = `${event.clientY - box.top}px`;
  }

  private drawNow(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.element.isConnected || width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    const { viewpoint, heading } = this.viewer.pose;
    const { position } = this.viewer.scan.viewpoints[viewpoint]!;
    this.you.position.set(position[0], position[1], position[2] - 0.4);
    this.you.rotation.z = -heading;
    this.you.visible = storeyOf(this.viewer.scan, viewpoint) <= this.storey;
    this.camera.aspect = width / height;
    // So far away that the building fits, however it is turned.
    const half = Math.atan(Math.tan(degrees(35) / 2) * Math.min(this.camera.aspect, 1));
    const away = (this.reach * this.zoom) / Math.sin(half);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(
      this.middle.x + away * Math.cos(this.height) * Math.sin(this.azimuth),
      this.middle.y - away * Math.cos(this.height) * Math.cos(this.azimuth),
      this.middle.z + away * Math.sin(this.height),
    );
    this.camera.lookAt(this.middle);
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }
}

type Quad = readonly [a: readonly [number, number], b: readonly [number, number], low: number, high: number];

/** Upright quads that face to the left of a to b: into a room whose corners run counter-clockwise. */
function quads(all: readonly Quad[]): three.BufferGeometry {
  const positions: number[] = [];
  const index: number[] = [];
  for (const [a, b, low, high] of all) {
    const first = positions.length / 3;
    positions.push(...a, low, ...b, low, ...b, high, ...a, high);
    index.push(first, first + 2, first + 1, first, first + 3, first + 2);
  }
  const geometry = new three.BufferGeometry();
  geometry.setAttribute('position', new three.Float32BufferAttribute(positions, 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
  return geometry;
}
