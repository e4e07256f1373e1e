/** The picture: from the eyes of the walker, or the building from outside. */
import * as three from 'three';
import { degrees, type Vec3, worldFromCamera } from '../geometry/geometry.ts';
import { drawsWithoutGpu } from '../viewer/gpu.ts';
import { Building } from './building.ts';
import type { GlbMesh } from './glb.ts';
import { Marks } from './marks.ts';
import { Pace } from './pace.ts';
import type { Walker } from './walker.ts';

export type Mode = 'inside' | 'house';

/** A camera's pose: all that changes between the two modes. */
interface Shot { readonly position: three.Vector3; readonly turned: three.Quaternion; readonly fov: number; readonly near: number }

const smooth = (t: number): number => t * t * (3 - 2 * t);
const clamped = (t: number): number => Math.min(Math.max(t, 0), 1);

/** VLN-CE's pictures have 90 degrees from side to side; a screen is wider: this is from top to bottom. */
const insideView = degrees(65);
const houseView = degrees(35);
/** What the sky looks like, through windows and from above. */
const sky = { top: new three.Color(0x7fa9d8), low: new three.Color(0xdfe9f2) } as const;

/** The least scale of a moving picture, and where it begins without a GPU. */
const leastScale = 0.5;
const withoutGpu = { least: 0.25, first: 0.35 } as const;
/** Milliseconds without a change, after which one frame is drawn with all its pixels. */
const restAfter = 400;
/** A frame that is asked for so soon after the last one, milliseconds, belongs to the same motion. */
const sameMotion = 30;
/** Between the doll's house and the floor: down, then what was cut off comes back. Seconds, metres. */
const descent = 1.6;
const raising = 0.5;
const raised = 1.6;

const mostElevation = degrees(89);
const leastElevation = degrees(10);

export class RoamView {
  readonly element = document.createElement('div');
  readonly canvas: HTMLCanvasElement;
  readonly marks = new Marks();
  private readonly renderer: three.WebGLRenderer;
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(60, 1, 0.04, 300);
  private readonly sky = backdrop();
  private readonly resizes = new ResizeObserver(() => this.draw());
  private readonly walker: Walker;
  private readonly building: Building;
  private shown: Mode = 'inside';
  private ceiling = Infinity;
  private azimuth = degrees(25);
  private height = degrees(55);
  private zoom = 1;
  private frame = 0;
  private readonly pace: Pace;
  private asked = 0;
  private begun = 0;
  private ended = 0;
  private rest = 0;
  private size = '';
  private drawn = 0;
  private flight: { readonly share: number } | undefined;
  private endFlight: () => void = () => {};

  private constructor(walker: Walker, building: Building, slow: boolean) {
    this.walker = walker;
    this.building = building;
    this.renderer = new three.WebGLRenderer({ antialias: !slow, alpha: true });
    this.pace = slow ? new Pace(withoutGpu.least, withoutGpu.first) : new Pace(leastScale);
    this.renderer.setOpaqueSort((a, b) => a.z - b.z); // the nearest first: what it hides is not computed
    for (const texture of building.textures) this.renderer.initTexture(texture); // or the first look at each would stutter
    this.renderer.setClearAlpha(0); // a doll's house stands on the page's own colour
    this.renderer.outputColorSpace = three.SRGBColorSpace;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.element.className = 'roam-view';
    this.element.append(this.canvas);
    this.scene.add(building.group, this.marks.group);
    this.resizes.observe(this.element);
    walker.onChange(() => this.draw());
    this.show('inside');
  }

  /** Throws Error without WebGL 2. */
  static async open(walker: Walker, mesh: GlbMesh): Promise<RoamView> {
    const slow = isSlow();
    return new RoamView(walker, await Building.make(mesh, slow), slow);
  }

  /** Drawn since the page was opened, for measurements. */
  get frames(): number {
    return this.drawn;
  }

  /** What the last frame took to draw. */
  get cost(): { readonly calls: number; readonly triangles: number } {
    const { calls, triangles } = this.renderer.info.render;
    return { calls, triangles };
  }

  /** The share of a moving picture's width and height that the machine's speed allows. */
  get scale(): number {
    return this.pace.scale;
  }

  get mode(): Mode {
    return this.shown;
  }

  /** @param ceiling of the doll's house, world z */
  show(mode: Mode, ceiling = this.ceiling): void {
    this.endFlight();
    this.shown = mode;
    this.ceiling = ceiling;
    if (mode === 'inside') this.building.showInside();
    else this.building.showOutside(ceiling);
    this.scene.background = mode === 'inside' ? this.sky : null;
    this.element.dataset['mode'] = mode;
    this.draw();
  }

  /** Whether it flies from one mode to the other. */
  get flying(): boolean {
    return this.flight !== undefined;
  }

  /**
   * As show(), by a flight of two seconds to the walker's eyes or from them; at once where people asked for less motion.
   * Resolves when it is there, or when something else is shown. @returns whether it came there
   */
  async fly(mode: Mode, ceiling = this.ceiling): Promise<boolean> {
    const from = this.shown;
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.show(from === mode || still ? mode : 'house', ceiling);
    if (from === mode || still) return true;
    const [all, begin] = [descent + raising, performance.now()];
    let ended = false;
    await new Promise<void>((resolve) => {
      this.endFlight = () => {
        [this.flight, ended, this.endFlight] = [undefined, true, () => {}];
        resolve();
      };
      const step = (): void => {
        if (ended) return;
        const seconds = (performance.now() - begin) / 1000;
        if (seconds >= all) return resolve();
        this.flight = { share: mode === 'inside' ? seconds : all - seconds };
        this.draw();
        requestAnimationFrame(step);
      };
      step();
    });
    if (ended) return false;
    this.show(mode, ceiling);
    return true;
  }

  /** Turns the building from outside; radians. */
  orbit(around: number, up: number): void {
    this.azimuth -= around;
    this.height = Math.min(Math.max(this.height + up, leastElevation), mostElevation);
    this.draw();
  }

  zoomBy(factor: number): void {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 2);
    this.draw();
  }

  /** The heading in which one looks at the building from outside. */
  get facing(): number {
    return -this.azimuth;
  }

  /** Radians that a pixel of the middle of the picture is wide. */
  get perPixel(): number {
    return (2 * Math.tan(insideView / 2)) / Math.max(this.element.clientHeight, 1);
  }

  /** The line of sight through a point of the canvas: where it begins, and a direction. */
  rayAt(x: number, y: number): readonly [Vec3, Vec3] {
    const { clientWidth, clientHeight } = this.element;
    const ray = new three.Raycaster();
    ray.setFromCamera(new three.Vector2((x / clientWidth) * 2 - 1, 1 - (y / clientHeight) * 2), this.camera);
    return [ray.ray.origin.toArray(), ray.ray.direction.toArray()];
  }

  /** Where a ring of 1 m on the floor lies in the picture, CSS pixels; nothing where it is behind one. */
  ringAt(at: Vec3): { readonly x: number; readonly y: number; readonly wide: number; readonly high: number } | undefined {
    const { clientWidth, clientHeight } = this.element;
    const middle = new three.Vector3(...at);
    const along = middle.clone().sub(this.camera.position);
    const seen = middle.project(this.camera);
    if (seen.z > 1) return undefined;
    const wide = clientHeight / 2 / Math.tan((this.camera.fov * Math.PI) / 360) / along.length();
    return { x: ((seen.x + 1) / 2) * clientWidth, y: ((1 - seen.y) / 2) * clientHeight, wide, high: (wide * Math.abs(along.z)) / along.length() };
  }

  /** At the next frame. */
  draw(): void {
    if (this.frame !== 0) return;
    this.asked = performance.now();
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.drawNow();
    });
  }

  /** The picture as RGBA rows from below, for tests. */
  capture(width: number, height: number): Uint8Array {
    const target = new three.WebGLRenderTarget(width, height);
    const pixels = new Uint8Array(width * height * 4);
    this.aim(width / height);
    this.renderer.setRenderTarget(target);
    this.renderer.render(this.scene, this.camera);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    target.dispose();
    return pixels;
  }

  /** @param whole with all pixels, as a picture at rest has them */
  private drawNow(whole = false): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.element.isConnected || width === 0 || height === 0) return;
    clearTimeout(this.rest);
    const begin = performance.now();
    if (!whole && this.asked - this.ended < sameMotion) this.pace.took(begin - this.begun);
    this.begun = begin;
    const scale = whole ? 1 : this.pace.scale;
    if (scale < 1) this.rest = window.setTimeout(() => this.drawAtRest(), restAfter);
    this.resize(width, height, Math.min(devicePixelRatio, 2) * scale);
    const { position, heading, trail } = this.walker;
    this.marks.setYou(position, heading);
    this.marks.setTrail(trail);
    this.aim(width / height);
    this.marks.show(this.shown === 'house' && !this.flight, this.ceiling);
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
    this.ended = performance.now();
  }

  private drawAtRest(): void {
    if (this.frame === 0) this.drawNow(true); // else a frame is on its way: nothing is at rest, it is slow
  }

  private resize(width: number, height: number, ratio: number): void {
    const size = [width, height, ratio].join();
    if (size === this.size) return; // a new size is a new picture, even if it is the same
    this.size = size;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
  }

  private aim(aspect: number): void {
    this.camera.aspect = aspect;
    const shot = this.flight ? this.between(this.flight.share) : this.shown === 'inside' ? this.within() : this.outside();
    this.camera.position.copy(shot.position);
    this.camera.quaternion.copy(shot.turned);
    [this.camera.fov, this.camera.near] = [shot.fov, shot.near];
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /** A moment of a flight. It ends right above, so that no wall is in the way. @param seconds since it began, from outside */
  private between(seconds: number): Shot {
    const [from, to] = [this.outside(), this.within()];
    const share = smooth(clamped(seconds / descent));
    const rest = 1 - share;
    const over = new three.Vector3(to.position.x, to.position.y, (from.position.z + to.position.z) / 2);
    const up = smooth(clamped((seconds - descent) / raising));
    this.building.showOutside(this.ceiling + raised * up, rest);
    return {
      position: new three.Vector3().addScaledVector(from.position, rest * rest).addScaledVector(over, 2 * rest * share)
        .addScaledVector(to.position, share * share),
      turned: from.turned.clone().slerp(to.turned, smooth(clamped((share - 0.5) / 0.5))),
      fov: from.fov * rest + to.fov * share,
      near: to.near + (from.near - to.near) * rest * rest,
    };
  }

  private within(): Shot {
    const { eye, heading, elevation } = this.walker;
    const m = worldFromCamera({ heading, elevation });
    // three.js cameras look along -z with y up; ours along +z with y down.
    const matrix = new three.Matrix4().set(
      m[0], -m[1], -m[2], eye[0],
      m[3], -m[4], -m[5], eye[1],
      m[6], -m[7], -m[8], eye[2],
      0, 0, 0, 1,
    );
    const [position, turned] = [new three.Vector3(), new three.Quaternion()];
    matrix.decompose(position, turned, new three.Vector3());
    return { position, turned, fov: (insideView * 180) / Math.PI, near: 0.04 };
  }

  private outside(): Shot {
    const box = this.building.box.clone();
    box.max.z = Math.min(box.max.z, this.ceiling);
    const middle = box.getCenter(new three.Vector3());
    const size = box.getSize(new three.Vector3());
    const half = Math.atan(Math.tan(houseView / 2) * Math.min(this.camera.aspect, 1));
    const away = (size.length() / 2) * 0.95 * this.zoom / Math.sin(half);
    const position = new three.Vector3(
      middle.x + away * Math.cos(this.height) * Math.sin(this.azimuth),
      middle.y - away * Math.cos(this.height) * Math.cos(this.azimuth),
      middle.z + away * Math.sin(this.height),
    );
    const turned = new three.Quaternion().setFromRotationMatrix(new three.Matrix4().lookAt(position, middle, new three.Vector3(0, 0, 1)));
    return { position, turned, fov: (houseView * 180) / Math.PI, near: away / 50 };
  }
}

/** Asked before the renderer is made: a context is smoothed for ever or never. Throws Error without WebGL 2. */
function isSlow(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) throw new Error('This browser cannot show the building: it needs WebGL 2, which is off or missing here');
  const slow = drawsWithoutGpu(gl);
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return slow;
}

/** Light below, darker above. */
function backdrop(): three.Texture {
  const rows = 64;
  const bytes = new Uint8Array(rows * 4);
  for (let k = 0; k < rows; ++k) {
    const colour = sky.low.clone().lerp(sky.top, k / (rows - 1)).convertLinearToSRGB();
    bytes.set([colour.r * 255, colour.g * 255, colour.b * 255, 255], 4 * k);
  }
  const texture = new three.DataTexture(bytes, 1, rows);
  texture.colorSpace = three.SRGBColorSpace;
  texture.magFilter = three.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
