/** What is on the screen: one panorama, or the way between two, with discs. Knows no graph and no rules. */
import * as three from 'three';
import { type Direction, mix, type Vec3, worldFromCamera } from '../geometry/geometry.ts';
import { Discs } from './discs.ts';
import { drawsWithoutGpu } from './gpu.ts';
import { type Panorama, PanoramaMesh } from './panorama.ts';

/** A direction, and the vertical opening, radians. */
export interface Look extends Direction {
  readonly vfov: number;
}

/** How one gets from a panorama to the next: through space, or from one picture to the other. */
export type Passage = 'space' | 'fade';

const joinVertices = /* glsl */ `
  out vec2 at;
  void main() {
    at = uv;
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }`;

/** Of two pictures of one view the nearer viewpoint's counts, and the one that is to be trusted there. */
const joinFragments = /* glsl */ `
  in vec2 at;
  out vec4 colour;
  uniform sampler2D first;
  uniform sampler2D second;
  uniform float share;
  void main() {
    vec4 a = texture(first, at);
    vec4 b = texture(second, at);
    float wa = (1.0 - share) * a.a;
    float wb = share * b.a;
    colour = vec4(mix(a.rgb, b.rgb, wb / max(wa + wb, 1e-6)), 1.0);
  }`;

/** Frames that take longer than this are drawn smaller, milliseconds: 25 a second. */
const slowFrame = 40;
const leastScale = 0.5;

const smoothstep = (from: number, to: number, x: number): number => {
  const t = Math.min(Math.max((x - from) / (to - from), 0), 1);
  return t * t * (3 - 2 * t);
};

export class Stage {
  readonly canvas: HTMLCanvasElement;
  readonly discs = new Discs();
  private readonly renderer: three.WebGLRenderer;
  private readonly camera = new three.PerspectiveCamera(60, 1, 0.05, 100);
  private readonly here = new PanoramaMesh();
  private readonly there = new PanoramaMesh();
  private readonly rest = new three.Scene();
  private readonly marks = new three.Scene();
  private readonly reliefs = [new three.Scene(), new three.Scene()] as const;
  private readonly targets = [new three.WebGLRenderTarget(1, 1), new three.WebGLRenderTarget(1, 1)] as const;
  private readonly join: three.Mesh<three.PlaneGeometry, three.ShaderMaterial>;
  private readonly joined = new three.Scene();
  private from: Panorama | undefined;
  private to: Panorama | undefined;
  private size = { width: 1, height: 1 };
  /** Of the picture in a glide; smaller where drawing is slow. */
  private scale = 1;
  private before = 0;
  private compiled = false;
  private slow = 0;

  /** Throws Error without WebGL. */
  constructor() {
    this.renderer = new three.WebGLRenderer({ antialias: false, preserveDrawingBuffer: false });
    this.renderer.outputColorSpace = three.LinearSRGBColorSpace; // values pass as they are
    this.renderer.autoClear = false;
    if (drawsWithoutGpu(this.renderer.getContext())) this.scale = leastScale;
    this.canvas = this.renderer.domElement;
    this.canvas.classList.add('enfilade-canvas');
    this.here.box.renderOrder = 0;
    this.there.box.renderOrder = 1;
    this.rest.add(this.here.box, this.there.box);
    this.reliefs[0].add(this.here.relief);
    this.reliefs[1].add(this.there.relief);
    this.marks.add(this.discs.group);
    this.join = new three.Mesh(new three.PlaneGeometry(2, 2), new three.ShaderMaterial({
      glslVersion: three.GLSL3, vertexShader: joinVertices, fragmentShader: joinFragments,
      depthTest: false, depthWrite: false,
      uniforms: {
        first: { value: this.targets[0].texture }, second: { value: this.targets[1].texture }, share: { value: 0 },
      },
    }));
    this.join.frustumCulled = false;
    this.joined.add(this.join);
  }

  /** CSS pixels. */
  resize(width: number, height: number): void {
    this.size = { width, height };
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
  }

  /** Where one stands. */
  stand(panorama: Panorama): void {
    this.from = panorama;
    this.here.show(panorama);
    this.discs.hideBehind(panorama);
  }

  /** Where one goes to next. */
  head(panorama: Panorama): void {
    this.to = panorama;
    this.there.show(panorama);
  }

  /** Makes ready what heading there will need, so that its first frame is as quick as the others. */
  prepare({ picture, distances }: Panorama): void {
    this.renderer.initTexture(picture);
    if (!distances) return;
    this.renderer.initTexture(distances.texture);
    if (this.compiled) return;
    this.compiled = true;
    for (const scene of [...this.reliefs, this.joined]) this.renderer.compile(scene, this.camera);
  }

  /** From where one stands. */
  draw(look: Look): void {
    if (!this.from) return; // nothing has come yet
    this.drawBox(look, this.from.position, 0);
    this.drawMarks(1, 1);
    this.before = 0;
  }

  /** On the way: share 0 to 1 of it. @param arrival where one looks after a fade, if not as before */
  drawBetween(look: Look, share: number, passage: Passage, arrival: Direction = look): void {
    const [from, to] = [this.from!, this.to!];
    if (passage === 'fade') {
      // Both as from their own eyes, and the second one as it is looked at then: nothing moves.
      const { box } = this.there;
      box.position.set(...from.position);
      box.setRotationFromMatrix(poseOf(look).multiply(poseOf(arrival).transpose()));
      this.drawBox(look, from.position, share);
      box.position.set(...to.position);
      box.quaternion.identity();
      this.drawMarks(1 - share, 1 - share);
      return;
    }
    const eye = mix(from.position, to.position, share);
    if (from.distances && to.distances) this.drawReliefs(look, eye, share);
    else this.drawBox(look, eye, share);
    this.drawMarks(1 - smoothstep(0.4, 0.9, share), 1);
  }

  /** The picture without discs, RGBA rows from the top, of any size: what the simulator draws. */
  capture(look: Look, width: number, height: number): Uint8Array {
    const target = new three.WebGLRenderTarget(width, height);
    const pixels = new Uint8Array(width * height * 4);
    this.renderer.setRenderTarget(target);
    this.renderer.clear();
    this.aim(this.from!.position, look, width / height);
    this.there.setOpacity(0);
    this.renderer.render(this.rest, this.camera);
    this.renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    target.dispose();
    return flipped(pixels, width * 4);
  }

  dispose(): void {
    for (const part of [this.here, this.there, this.discs, ...this.targets]) part.dispose();
    this.join.geometry.dispose();
    this.join.material.dispose();
    this.renderer.dispose();
    this.canvas.remove();
  }

  private drawBox(look: Look, eye: Vec3, share: number): void {
    this.there.setOpacity(share);
    this.aim(eye, look, this.size.width / this.size.height);
    this.renderer.clear();
    this.renderer.render(this.rest, this.camera);
  }

  private drawReliefs(look: Look, eye: Vec3, share: number): void {
    this.mindSpeed();
    const pixels = this.renderer.getDrawingBufferSize(new three.Vector2()).multiplyScalar(this.scale).round();
    this.aim(eye, look, this.size.width / this.size.height);
    this.targets.forEach((target, k) => {
      target.setSize(pixels.x, pixels.y); // nothing, if it has that size
      this.renderer.setRenderTarget(target);
      this.renderer.setClearAlpha(0);
      this.renderer.clear();
      this.renderer.render(this.reliefs[k]!, this.camera);
    });
    this.renderer.setRenderTarget(null);
    this.join.material.uniforms['share']!.value = smoothstep(0.1, 0.9, share);
    this.renderer.clear();
    this.renderer.render(this.joined, this.camera);
  }

  /** A glide of few frames looks worse than one of few pixels. */
  private mindSpeed(): void {
    const now = performance.now();
    const took = now - this.before;
    if (this.before > 0 && took < 1000) this.slow = took > slowFrame ? this.slow + 1 : 0;
    if (this.slow >= 2 && this.scale > leastScale) {
      this.scale = Math.max(this.scale * Math.sqrt(slowFrame / took), leastScale); // time goes with the pixels
      this.slow = 0;
    }
    this.before = now;
  }

  private drawMarks(steps: number, path: number): void {
    this.discs.setOpacity(steps, path);
    this.renderer.render(this.marks, this.camera);
  }

  private aim(eye: Vec3, look: Look, aspect: number): void {
    this.camera.setRotationFromMatrix(poseOf(look));
    this.camera.position.set(...eye);
    this.camera.fov = (look.vfov * 180) / Math.PI;
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }
}

/** World from camera, as three.js has cameras: they look along -z with y up, ours along +z with y down. */
function poseOf(look: Direction): three.Matrix4 {
  const m = worldFromCamera(look);
  return new three.Matrix4().set(
    m[0], -m[1], -m[2], 0,
    m[3], -m[4], -m[5], 0,
    m[6], -m[7], -m[8], 0,
    0, 0, 0, 1,
  );
}

/** Rows in the other order: OpenGL's first is the lowest. */
function flipped(pixels: Uint8Array, stride: number): Uint8Array {
  const out = new Uint8Array(pixels.length);
  for (let row = 0, last = pixels.length - stride; row <= last; row += stride) {
    out.set(pixels.subarray(last - row, last - row + stride), row);
  }
  return out;
}
