/** A building's mesh as three.js draws it: its own light, cut off above a height. */
import * as three from 'three';
import type { GlbMesh, Part } from './glb.ts';

const vertices = /* glsl */ `
  in vec3 light;
  out vec2 at;
  out vec3 lit;
  out float height;
  void main() {
    at = uv;
    lit = light;
    height = position.z;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

// The tone curve is the renderer's (enfilade/image/tone.h): linear up to the knee.
const fragments = /* glsl */ `
  in vec2 at;
  in vec3 lit;
  in float height;
  out vec4 seen;
  uniform sampler2D picture;
  uniform vec3 colour;
  uniform float cutoff;
  uniform float ceiling;
  uniform bool exposed;
  uniform bool outside;
  uniform float gain;
  vec3 shoulder(vec3 light) {
    const float knee = 0.4;
    return mix(light, knee + (1.0 - knee) * (1.0 - exp((knee - light) / (1.0 - knee))), step(knee, light));
  }
  vec3 display(vec3 light) {
    return mix(light * 12.92, 1.055 * pow(max(light, 0.0), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light));
  }
  void main() {
    if (height > ceiling) discard;
    vec4 texel = texture(picture, at);
    if (texel.a < cutoff) discard;
    vec3 light = texel.rgb * colour * lit * gain;
    if (exposed) light = shoulder(light);
    seen = vec4(display(light), 1.0);
    // Walls are hollow: where they are cut one sees the inside of their other side.
    if (outside && !gl_FrontFacing) seen = vec4(0.23, 0.25, 0.29, 1.0);
  }`;

/** From outside a building is small beside a light page: rooms as the eye of a visitor sees them look dark there. */
const outsideGain = 1.7;

/** A picture of one white texel, for materials without any. */
const white = (): three.Texture => {
  const texture = new three.DataTexture(new Uint8Array([255, 255, 255, 255]), 1, 1);
  texture.needsUpdate = true;
  return texture;
};

async function textureOf(picture: Blob): Promise<three.Texture> {
  const bitmap = await createImageBitmap(picture, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
  const texture = new three.Texture(bitmap);
  texture.flipY = false; // glTF's first row is the top one
  texture.colorSpace = three.SRGBColorSpace;
  texture.wrapS = texture.wrapT = three.RepeatWrapping;
  texture.minFilter = three.LinearMipmapLinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function geometryOf({ positions, indices, texturePoints, light }: Part): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  const corners = positions.length / 3;
  geometry.setAttribute('position', new three.BufferAttribute(positions, 3));
  geometry.setAttribute('uv', new three.BufferAttribute(texturePoints ?? new Float32Array(2 * corners), 2));
  geometry.setAttribute('light', new three.BufferAttribute(light ?? new Float32Array(3 * corners).fill(1), 3));
  geometry.setIndex(new three.BufferAttribute(indices, 1));
  return geometry;
}

export class Building {
  readonly group = new three.Group();
  /** Around what belongs to the building. */
  readonly box = new three.Box3();
  private readonly around = new three.Group();
  /** Whether its colours are light, of which a screen shows a part. */
  private readonly exposed: boolean;
  private readonly materials: readonly three.ShaderMaterial[];

  private constructor(mesh: GlbMesh, pictures: readonly three.Texture[]) {
    const exposed = mesh.parts.some(({ light }) => light !== undefined);
    this.exposed = exposed;
    this.materials = mesh.materials.map(({ colour, cutoff }, k) => new three.ShaderMaterial({
      glslVersion: three.GLSL3, vertexShader: vertices, fragmentShader: fragments, side: three.DoubleSide,
      uniforms: {
        picture: { value: pictures[k] }, colour: { value: new three.Vector3(...colour) }, cutoff: { value: cutoff },
        ceiling: { value: 1e9 }, exposed: { value: exposed }, outside: { value: false }, gain: { value: 1 },
      },
    }));
    for (const part of mesh.parts) {
      const made = new three.Mesh(geometryOf(part), this.materials[part.material]);
      const surroundings = part.name === 'surroundings';
      (surroundings ? this.around : this.group).add(made);
      if (!surroundings) this.box.expandByObject(made);
    }
    this.group.add(this.around);
  }

  static async make(mesh: GlbMesh): Promise<Building> {
    const plain = white();
    return new Building(mesh, await Promise.all(mesh.materials.map(({ picture }) => (picture ? textureOf(picture) : plain))));
  }

  /** As one stands in it. */
  showInside(): void {
    this.around.visible = true;
    this.set(1e9, false);
  }

  /** As a doll's house: nothing above a height, world z, and nothing around it. */
  showOutside(ceiling: number): void {
    this.around.visible = false;
    this.set(ceiling, true);
  }

  private set(ceiling: number, outside: boolean): void {
    for (const { uniforms } of this.materials) {
      uniforms['ceiling']!.value = ceiling;
      uniforms['outside']!.value = outside;
      uniforms['gain']!.value = outside && this.exposed ? outsideGain : 1;
    }
  }
}
