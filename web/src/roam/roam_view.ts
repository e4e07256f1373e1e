/** The picture: from the eyes of the walker, or the building from outside. */
import * as three from 'three';
import { degrees, type Vec3, worldFromCamera } from '../geometry/geometry.ts';
import { drawsWithoutGpu } from '../viewer/gpu.ts';
import { Building } from './building.ts';
import type { GlbMesh } from './glb.ts';
import { Marks } from './marks.ts';
import type { Walker } from './walker.ts';

export type Mode = 'inside' | 'house';

/** VLN-CE's pictures have 90 degrees from side to side; a screen is wider: this is from top to bottom. */
const insideView = degrees(65);
const houseView = degrees(35);
/** What the sky looks like, through windows and from above. */
const sky = { top: new three.Color(0x7fa9d8), low: new three.Color(0xdfe9f2) } as const;

/** Frames that take longer are drawn smaller, milliseconds. */
const slowFrame = 60;
const leastScale = 0.5;
/** Milliseconds without a change, after which one frame is drawn with all its pixels. */
const restAfter = 400;

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
  private scale = 1;
  private slow = 0;
  private rest = 0;

  private constructor(walker: Walker, building: Building) {
    this.walker = walker;
    this.building = building;
    const slow = isSlow();
    this.renderer = new three.WebGLRenderer({ antialias: !slow, alpha: true });
    if (slow) this.scale = leastScale;
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
    return new RoamView(walker, await Building.make(mesh));
  }

  get mode(): Mode {
    return this.shown;
  }

  /** @param ceiling of the doll's house, world z */
  show(mode: Mode, ceiling = this.ceiling): void {
    this.shown = mode;
    this.ceiling = ceiling;
    if (mode === 'inside') this.building.showInside();
    else this.building.showOutside(ceiling);
    this.scene.background = mode === 'inside' ? this.sky : null;
    this.element.dataset['mode'] = mode;
    this.draw();
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

  /** At the next frame. */
  draw(): void {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => this.drawNow());
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

  /** @param scale of the picture's pixels */
  private drawNow(scale = this.scale): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.element.isConnected || width === 0 || height === 0) return;
    clearTimeout(this.rest);
    if (scale < 1) this.rest = window.setTimeout(() => this.drawNow(1), restAfter);
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * scale);
    this.renderer.setSize(width, height, false);
    const { position, heading, trail } = this.walker;
    this.marks.setYou(position, heading);
    this.marks.setTrail(trail);
    this.marks.show(this.shown === 'house', this.ceiling);
    this.aim(width / height);
    const before = performance.now();
    this.renderer.render(this.scene, this.camera);
    this.renderer.getContext().finish(); // or slow drawing is not noticed
    if (scale === this.scale) this.mindSpeed(performance.now() - before);
  }

  /** A walk of few frames looks worse than one of few pixels. */
  private mindSpeed(took: number): void {
    this.slow = took > slowFrame ? this.slow + 1 : 0;
    if (this.slow < 3 || this.scale <= leastScale) return;
    this.scale = Math.max(this.scale * Math.sqrt(slowFrame / took), leastScale);
    this.slow = 0;
  }

  private aim(aspect: number): void {
    this.camera.aspect = aspect;
    if (this.shown === 'inside') this.stand();
    else this.stepBack();
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  private stand(): void {
    const { eye, heading, elevation } = this.walker;
    const m = worldFromCamera({ heading, elevation });
    // three.js cameras look along -z with y up; ours along +z with y down.
    new three.Matrix4().set(
      m[0], -m[1], -m[2], eye[0],
      m[3], -m[4], -m[5], eye[1],
      m[6], -m[7], -m[8], eye[2],
      0, 0, 0, 1,
    ).decompose(this.camera.position, this.camera.quaternion, this.camera.scale);
    [this.camera.near, this.camera.fov] = [0.04, (insideView * 180) / Math.PI];
  }

  private stepBack(): void {
    const box = this.building.box.clone();
    box.max.z = Math.min(box.max.z, this.ceiling);
    const middle = box.getCenter(new three.Vector3());
    const size = box.getSize(new three.Vector3());
    const half = Math.atan(Math.tan(houseView / 2) * Math.min(this.camera.aspect, 1));
    const away = (size.length() / 2) * 0.95 * this.zoom / Math.sin(half);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(
      middle.x + away * Math.cos(this.height) * Math.sin(this.azimuth),
      middle.y - away * Math.cos(this.height) * Math.cos(this.azimuth),
      middle.z + away * Math.sin(this.height),
    );
    this.camera.lookAt(middle);
    [this.camera.near, this.camera.fov] = [away / 50, (houseView * 180) / Math.PI];
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
