/** One viewpoint's panorama: its pictures, and drawing it as a box around its eye or as a relief. */
import * as three from 'three';
import { apply, type Mat3, transpose, type Vec3 } from '../geometry/geometry.ts';
import type { Layer } from '../scan/scan.ts';
import { type Api, reach } from '../server/api.ts';
import { Kept } from './kept.ts';
import { cubeOrder, pointOfCube, Surround } from './surround.ts';

/** Distances as a texture, for shaders, and as numbers. */
class SurroundTexture {
  readonly surround: Surround;
  readonly texture: three.CubeTexture;

  constructor(surround: Surround) {
    this.surround = surround;
    const { size } = surround;
    // Half precision is 4 mm at 8 m, and can be filtered everywhere.
    this.texture = new three.CubeTexture(surround.faces.map((face) => new three.DataTexture(
      Uint16Array.from(face, (metres) => three.DataUtils.toHalfFloat(metres)),
      size, size, three.RedFormat, three.HalfFloatType)) as unknown as HTMLImageElement[]);
    this.texture.format = three.RedFormat;
    this.texture.type = three.HalfFloatType;
    this.texture.colorSpace = three.NoColorSpace;
    this.texture.generateMipmaps = false;
    this.texture.unpackAlignment = 1; // rows of any length
    this.texture.minFilter = three.LinearFilter;
    this.texture.magFilter = three.LinearFilter;
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.texture.dispose();
  }
}

/** What is drawn of a viewpoint. */
export interface Panorama {
  readonly position: Vec3;
  /** World from panorama. */
  readonly rotation: Mat3;
  readonly picture: three.CubeTexture;
  /** Over the picture, so much of it. */
  readonly overlay?: { readonly picture: three.CubeTexture; readonly share: number };
  /** Absent where the scan has no depth. */
  readonly distances?: SurroundTexture;
}

/** Half the box's edge, metres. Matters only where there is no depth, while one moves. */
const roomSize = 4;
/** Squares of a face's edge in a relief: 1.4 degrees, and 49,000 triangles. */
const squares = 64;
/** Pieces of a face's edge: those out of view are not drawn, which are two in three. */
const pieces = 4;

const boxVertices = /* glsl */ `
  out vec3 ray;
  void main() {
    ray = position;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

/** The cube pushed out to what one sees: the same picture from its eye, and a room from elsewhere. */
const reliefVertices = /* glsl */ `
  out vec3 ray;
  uniform samplerCube distances;
  uniform mat3 panoramaFromWorld;
  void main() {
    vec3 g = normalize(position);
    ray = transpose(panoramaFromWorld) * (-g * textureLod(distances, g, 0.0).r);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(ray, 1.0);
  }`;

const picture = /* glsl */ `
  in vec3 ray;
  out vec4 colour;
  uniform samplerCube picture;
  uniform samplerCube overlay;
  uniform float overlayShare;
  uniform mat3 panoramaFromWorld;
  vec3 seen() {
    vec3 g = -(panoramaFromWorld * ray);
    vec3 plain = texture(picture, g).rgb;
    return overlayShare > 0.0 ? mix(plain, texture(overlay, g).rgb, overlayShare) : plain;
  }`;

const boxFragments = /* glsl */ `${picture}
  uniform float opacity;
  void main() {
    colour = vec4(seen(), opacity);
  }`;

/**
 * Alpha is how far the picture is to be trusted: little where a surface is spanned between something
 * near and what is behind it, which no camera saw.
 */
const reliefFragments = /* glsl */ `${picture}
  void main() {
    vec3 normal = normalize(cross(dFdx(ray), dFdy(ray)));
    float facing = abs(dot(normal, normalize(ray)));
    colour = vec4(seen(), max(smoothstep(0.03, 0.14, facing), 0.008));
  }`;

/** A part of a relief's cube, and where it is once it is pushed out. */
class Piece {
  readonly mesh: three.Mesh<three.BufferGeometry, three.ShaderMaterial>;
  private readonly face: number;
  private readonly s: readonly [number, number];
  private readonly t: readonly [number, number];
  private readonly bounds = new three.Sphere();

  constructor(face: number, row: number, column: number, material: three.ShaderMaterial) {
    this.face = face;
    const side = (k: number) => (k / pieces) * 2 - 1;
    this.s = [side(column), side(column + 1)];
    this.t = [side(row), side(row + 1)];
    const many = squares / pieces;
    const at = ([from, to]: readonly [number, number], k: number) => from + ((to - from) * k) / many;
    const positions: number[] = [];
    const index: number[] = [];
    for (let y = 0; y <= many; ++y) {
      for (let x = 0; x <= many; ++x) {
        positions.push(...pointOfCube(face, at(this.s, x), at(this.t, y)));
        if (x === many || y === many) continue;
        const k = y * (many + 1) + x;
        index.push(k, k + 1, k + many + 1, k + many + 1, k + 1, k + many + 2);
      }
    }
    const geometry = new three.BufferGeometry();
    geometry.setAttribute('position', new three.Float32BufferAttribute(positions, 3));
    geometry.setIndex(index);
    geometry.boundingSphere = this.bounds;
    this.mesh = new three.Mesh(geometry, material);
  }

  /** Finds its bounds: a sphere around the part of a cone between the least and the greatest distance. */
  place(surround: Surround, worldFromPanorama: Mat3): void {
    const [least, most] = surround.range(this.face, this.s, this.t);
    const unit = (s: number, t: number) => new three.Vector3(...pointOfCube(this.face, s, t)).normalize();
    const middle = unit((this.s[0] + this.s[1]) / 2, (this.t[0] + this.t[1]) / 2);
    const half = (least + most) / 2;
    let radius = 0;
    // What is farthest from its middle lies at a corner, at either distance.
    for (const s of this.s) {
      for (const t of this.t) {
        const cosine = middle.dot(unit(s, t));
        for (const d of [least, most]) radius = Math.max(radius, Math.sqrt(d * d + half * half - 2 * d * half * cosine));
      }
    }
    this.bounds.center.set(...apply(worldFromPanorama, [-middle.x * half, -middle.y * half, -middle.z * half]));
    this.bounds.radius = radius;
  }
}

const uniformsOf = () => ({
  picture: { value: null as three.CubeTexture | null },
  overlay: { value: null as three.CubeTexture | null },
  overlayShare: { value: 0 },
  opacity: { value: 1 },
  distances: { value: null as three.CubeTexture | null },
  panoramaFromWorld: { value: new three.Matrix3() },
});

/** Draws a panorama, and then another one. */
export class PanoramaMesh {
  /** As seen from its eye. */
  readonly box: three.Mesh<three.BoxGeometry, three.ShaderMaterial>;
  /** As seen from near its eye; only where there are distances. */
  readonly relief = new three.Group();
  private readonly pieces: readonly Piece[];
  private readonly uniforms = uniformsOf();

  constructor() {
    const common = { glslVersion: three.GLSL3, uniforms: this.uniforms } as const;
    this.box = new three.Mesh(
      new three.BoxGeometry(2 * roomSize, 2 * roomSize, 2 * roomSize),
      new three.ShaderMaterial({
        ...common, vertexShader: boxVertices, fragmentShader: boxFragments, side: three.BackSide,
        transparent: true, depthTest: false, depthWrite: false,
      }),
    );
    const material = new three.ShaderMaterial({
      ...common, vertexShader: reliefVertices, fragmentShader: reliefFragments, side: three.DoubleSide,
    });
    this.pieces = Array.from({ length: 6 * pieces * pieces }, (_, k) =>
      new Piece(Math.floor(k / pieces ** 2), Math.floor(k / pieces) % pieces, k % pieces, material));
    this.relief.add(...this.pieces.map(({ mesh }) => mesh));
  }

  show({ position, rotation, picture: faces, overlay, distances }: Panorama): void {
    this.box.position.set(...position);
    this.relief.position.set(...position);
    this.uniforms.panoramaFromWorld.value.set(...transpose(rotation));
    this.uniforms.picture.value = faces;
    this.uniforms.overlay.value = overlay?.picture ?? faces;
    this.uniforms.overlayShare.value = overlay?.share ?? 0;
    this.uniforms.distances.value = distances?.texture ?? null;
    if (distances) for (const piece of this.pieces) piece.place(distances.surround, rotation);
  }

  setOpacity(opacity: number): void {
    this.uniforms.opacity.value = opacity;
    this.box.visible = opacity > 0;
  }

  dispose(): void {
    for (const mesh of [this.box, ...this.pieces.map((piece) => piece.mesh)]) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
  }
}

/** Pictures and distances of a scan's viewpoints, the latest used ones. */
export class Pictures {
  private readonly api: Api;
  private readonly scan: string;
  private readonly faces = new Kept(16, (key) => this.fetchFaces(key));
  private readonly surrounds = new Kept(32, async (viewpoint) =>
    new SurroundTexture(Surround.parse(await this.api.distances(this.scan, viewpoint))));

  constructor(api: Api, scan: string) {
    this.api = api;
    this.scan = scan;
  }

  get(viewpoint: string, layer: Layer): Promise<three.CubeTexture> {
    return this.faces.get(`${layer}/${viewpoint}`);
  }

  distances(viewpoint: string): Promise<SurroundTexture> {
    return this.surrounds.get(viewpoint);
  }

  dispose(): void {
    this.faces.dispose();
    this.surrounds.dispose();
  }

  private async fetchFaces(key: string): Promise<three.CubeTexture> {
    const [layer, viewpoint] = [key.slice(0, key.indexOf('/')) as Layer, key.slice(key.indexOf('/') + 1)];
    const bitmaps = await Promise.all(
      cubeOrder.map(async (face) => {
        const response = await reach(this.api.face(this.scan, viewpoint, layer, face));
        if (!response.ok) throw new Error(`no ${layer} picture of viewpoint ${viewpoint}`);
        return createImageBitmap(await response.blob(), {
          colorSpaceConversion: 'none',
          premultiplyAlpha: 'none',
        });
      }),
    );
    const texture = new three.CubeTexture(bitmaps);
    texture.colorSpace = three.NoColorSpace; // the very values of the file reach the screen
    texture.generateMipmaps = false; // as the simulator filters
    // Classes must not be mixed into colours that stand for other classes.
    const filter = layer === 'colour' ? three.LinearFilter : three.NearestFilter;
    texture.minFilter = filter;
    texture.magFilter = filter;
    texture.needsUpdate = true;
    return texture;
  }
}
