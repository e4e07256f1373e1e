/** A building's mesh as three.js draws it: its own light, cut off above a height. */
import * as three from 'three';
import type { GlbMesh, Part } from './glb.ts';
import { inPieces } from './pieces.ts';

const vertices = /* glsl */ `
  in vec3 light;
  out vec3 lit;
  out float height;
  #ifdef PICTURE
    out vec2 at;
  #endif
  void main() {
    #ifdef PICTURE
      at = uv;
    #endif
    lit = light;
    height = position.z;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

// The tone curve is the renderer's (enfilade/image/tone.h): linear up to the knee. Where nothing is thrown away, what is hidden costs little.
const fragments = /* glsl */ `
  in vec3 lit;
  in float height;
  out vec4 seen;
  uniform float ceiling;
  uniform float gain;
  #ifdef PICTURE
    in vec2 at;
    uniform sampler2D picture;
    uniform vec3 colour;
    uniform float cutoff;
  #endif
  vec3 shoulder(vec3 light) {
    const float knee = 0.4;
    return mix(light, knee + (1.0 - knee) * (1.0 - exp((knee - light) / (1.0 - knee))), step(knee, light));
  }
  // sRGB within 0.2 of 255 by two roots: without a GPU powers are slow.
  vec3 display(vec3 light) {
    vec3 root = sqrt(max(light, 0.0));
    return mix(light * 12.92, 0.8237 * root + 0.3065 * sqrt(root) - 0.0521 * light - 0.0786, step(0.0031308, light));
  }
  void main() {
    #ifdef OUTSIDE
      if (height > ceiling) discard;
    #endif
    vec3 light = lit * gain;
    #ifdef PICTURE
      vec4 texel = texture(picture, at);
      #ifdef HOLES
        if (texel.a < cutoff) discard;
      #endif
      light *= texel.rgb * colour;
    #endif
    #ifdef EXPOSED
      light = shoulder(light);
    #endif
    seen = vec4(display(light), 1.0);
    #ifdef OUTSIDE
      // Walls are hollow: where they are cut one sees the inside of their other side.
      if (!gl_FrontFacing) seen = vec4(0.23, 0.25, 0.29, 1.0);
    #endif
  }`;

/** From outside a building is small beside a light page: rooms as the eye of a visitor sees them look dark there. */
const outsideGain = 1.7;

async function textureOf(picture: Blob, quick: boolean): Promise<three.Texture> {
  const bitmap = await createImageBitmap(picture, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
  const texture = new three.Texture(bitmap);
  texture.flipY = false; // glTF's first row is the top one
  texture.colorSpace = three.SRGBColorSpace;
  texture.wrapS = texture.wrapT = three.RepeatWrapping;
  texture.minFilter = quick ? three.LinearMipmapNearestFilter : three.LinearMipmapLinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function geometryOf({ positions, indices, texturePoints, light }: Part): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  geometry.setAttribute('position', new three.BufferAttribute(positions, 3));
  if (texturePoints) geometry.setAttribute('uv', new three.BufferAttribute(texturePoints, 2));
  geometry.setAttribute('light', new three.BufferAttribute(light ?? new Float32Array(positions.length).fill(1), 3));
  geometry.setIndex(new three.BufferAttribute(indices, 1));
  return geometry;
}

/** A piece's two materials: within the building nothing is cut off. */
interface Looks { readonly inside: three.ShaderMaterial; readonly outside: three.ShaderMaterial }

export class Building {
  readonly group = new three.Group();
  /** Around what belongs to the building. */
  readonly box = new three.Box3();
  readonly textures: readonly three.Texture[];
  private readonly around = new three.Group();
  private readonly pieces: { readonly mesh: three.Mesh; readonly looks: Looks }[] = [];
  /** Whether its colours are light, of which a screen shows a part. */
  private readonly exposed: boolean;
  private readonly ceiling = { value: 1e9 };
  private readonly gain = { value: 1 };

  private constructor(mesh: ReturnType<typeof inPieces>, exposed: boolean, pictures: readonly (three.Texture | undefined)[]) {
    this.exposed = exposed;
    this.textures = pictures.filter((picture) => picture !== undefined);
    const looks = new Map<string, Looks>();
    const looksOf = (material: number, solid: boolean): Looks => {
      const key = `${material} ${solid}`;
      const { colour, cutoff } = mesh.materials[material]!;
      const picture = pictures[material];
      const make = (outside: boolean) => new three.ShaderMaterial({
        glslVersion: three.GLSL3, vertexShader: vertices, fragmentShader: fragments, side: solid && !outside ? three.FrontSide : three.DoubleSide,
        defines: {
          ...(picture && { PICTURE: '' }), ...(picture && cutoff > 0 && { HOLES: '' }),
          ...(exposed && { EXPOSED: '' }), ...(outside && { OUTSIDE: '' }),
        },
        uniforms: {
          ceiling: this.ceiling, gain: this.gain,
          ...(picture && { picture: { value: picture }, colour: { value: new three.Vector3(...colour) }, cutoff: { value: cutoff } }),
        },
      });
      const known = looks.get(key) ?? { inside: make(false), outside: make(true) };
      looks.set(key, known);
      return known;
    };
    for (const part of mesh.parts) {
      const two = looksOf(part.material, part.solid);
      const made = new three.Mesh(geometryOf(part), two.inside);
      made.matrixAutoUpdate = false; // it never moves
      const surroundings = part.name === 'surroundings';
      (surroundings ? this.around : this.group).add(made);
      if (!surroundings) this.box.expandByObject(made);
      this.pieces.push({ mesh: made, looks: two });
    }
    this.group.add(this.around);
  }

  /** @param quick for drawing without a GPU: textures are filtered less, and of homes' solids only the outside is drawn */
  static async make(mesh: GlbMesh, quick: boolean): Promise<Building> {
    const exposed = mesh.parts.some(({ light }) => light !== undefined);
    const pieces = inPieces(mesh, quick && exposed);
    return new Building(pieces, exposed, await Promise.all(pieces.materials.map(({ picture }) => picture && textureOf(picture, quick))));
  }

  /** As one stands in it. */
  showInside(): void {
    this.set(true);
    this.gain.value = 1;
  }

  /**
   * As a doll's house: nothing above a height, world z, and nothing around it.
   * @param light how much lighter than within, 0 to 1 of the most
   */
  showOutside(ceiling: number, light = 1): void {
    this.set(false);
    this.ceiling.value = ceiling;
    this.gain.value = this.exposed ? 1 + (outsideGain - 1) * light : 1;
  }

  private set(inside: boolean): void {
    if (this.around.visible === inside && this.pieces[0]?.mesh.material === this.pieces[0]?.looks[inside ? 'inside' : 'outside']) return;
    this.around.visible = inside;
    for (const { mesh, looks } of this.pieces) mesh.material = inside ? looks.inside : looks.outside;
  }
}
