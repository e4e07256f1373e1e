/**
 * Reads a binary glTF file as the server writes it: triangles with one material each, vertex colours, pictures inside. three's own loader
 * takes pictures by blob: addresses, which our content policy forbids scripts to fetch.
 */

/** Triangles of one material. World frame: metres, z up. */
export interface Part {
  /** Of its node: "building", "surroundings". */
  readonly name: string;
  readonly material: number;
  readonly positions: Float32Array;
  readonly indices: Uint32Array;
  /** Two a corner. */
  readonly texturePoints?: Float32Array;
  /** Linear light, three a corner. */
  readonly light?: Float32Array;
}

interface Material {
  /** Linear. */
  readonly colour: readonly [number, number, number];
  /** No surface where a picture's alpha is below; 0: none. */
  readonly cutoff: number;
  /** A JPEG or PNG file. */
  readonly picture?: Blob;
}

export interface GlbMesh {
  readonly parts: readonly Part[];
  readonly materials: readonly Material[];
}

interface Primitive {
  readonly attributes: Readonly<Record<string, number>>;
  readonly indices: number;
  readonly material: number;
}

interface Accessor {
  readonly bufferView: number;
  readonly byteOffset?: number;
  readonly count: number;
  readonly componentType: number;
  readonly type: string;
}

interface GltfMaterial {
  readonly pbrMetallicRoughness?: { readonly baseColorFactor?: readonly number[]; readonly baseColorTexture?: { readonly index: number } };
  readonly alphaMode?: string;
  readonly alphaCutoff?: number;
}

interface Gltf {
  readonly nodes?: readonly { readonly name?: string; readonly mesh?: number }[];
  readonly meshes?: readonly { readonly primitives: readonly Primitive[] }[];
  readonly accessors?: readonly Accessor[];
  readonly bufferViews?: readonly { readonly byteOffset?: number; readonly byteLength: number; readonly byteStride?: number }[];
  readonly materials?: readonly GltfMaterial[];
  readonly textures?: readonly { readonly source: number }[];
  readonly images?: readonly { readonly bufferView: number; readonly mimeType: string }[];
}

const magic = 0x46546c67; // "glTF"
const jsonChunk = 0x4e4f534a;
const widths: Readonly<Record<string, number>> = { SCALAR: 1, VEC2: 2, VEC3: 3 };
const [float, unsignedInt] = [5126, 5125];

/** Throws Error for what is no such file. */
export function parseGlb(file: ArrayBuffer): GlbMesh {
  const view = new DataView(file);
  if (file.byteLength < 28 || view.getUint32(0, true) !== magic || view.getUint32(4, true) !== 2) {
    throw new Error('The mesh is no binary glTF 2.0 file');
  }
  const length = view.getUint32(12, true);
  if (view.getUint32(16, true) !== jsonChunk || 28 + length > file.byteLength) throw new Error('The mesh is cut off');
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 20, length))) as Gltf;
  const begin = 28 + length;

  const bytes = (index: number): { readonly offset: number; readonly length: number } => {
    const { byteOffset = 0, byteLength } = gltf.bufferViews![index]!;
    if (begin + byteOffset + byteLength > file.byteLength) throw new Error('The mesh is cut off');
    return { offset: begin + byteOffset, length: byteLength };
  };
  const numbers = <T extends Float32Array | Uint32Array>(
    index: number, component: number, make: (buffer: ArrayBuffer, offset: number, length: number) => T,
  ): T => {
    const { bufferView, byteOffset = 0, count, componentType, type } = gltf.accessors![index]!;
    const width = widths[type]!;
    const { byteStride } = gltf.bufferViews![bufferView]!;
    if (componentType !== component || (byteStride ?? 4 * width) !== 4 * width) throw new Error('The mesh has numbers of another kind');
    const { offset, length: most } = bytes(bufferView);
    if (byteOffset + 4 * width * count > most) throw new Error('The mesh is cut off');
    return make(file, offset + byteOffset, width * count);
  };
  const floats = (index: number) => numbers(index, float, (buffer, offset, n) => new Float32Array(buffer, offset, n));

  const parts: Part[] = [];
  for (const { name = '', mesh } of gltf.nodes ?? []) {
    if (mesh === undefined) continue;
    for (const { attributes, indices, material } of gltf.meshes![mesh]!.primitives) {
      const [uv, colour] = [attributes['TEXCOORD_0'], attributes['COLOR_0']];
      parts.push({
        name, material,
        positions: zUp(floats(attributes['POSITION']!)),
        indices: numbers(indices, unsignedInt, (buffer, offset, n) => new Uint32Array(buffer, offset, n)),
        ...(uv !== undefined && { texturePoints: floats(uv) }),
        ...(colour !== undefined && { light: floats(colour) }),
      });
    }
  }
  const materials = (gltf.materials ?? []).map(({ pbrMetallicRoughness: surface = {}, alphaMode, alphaCutoff = 0.5 }): Material => {
    const [r = 1, g = 1, b = 1] = surface.baseColorFactor ?? [];
    const texture = surface.baseColorTexture?.index;
    const picture = texture === undefined ? undefined : gltf.images![gltf.textures![texture]!.source]!;
    const place = picture && bytes(picture.bufferView);
    return {
      colour: [r, g, b], cutoff: alphaMode === 'MASK' ? alphaCutoff : 0,
      ...(place && { picture: new Blob([new Uint8Array(file, place.offset, place.length)], { type: picture.mimeType }) }),
    };
  });
  return { parts, materials };
}

/** glTF's (x, y, z) is our (x, -z, y). */
function zUp(positions: Float32Array): Float32Array {
  const out = new Float32Array(positions.length);
  for (let k = 0; k < positions.length; k += 3) {
    out[k] = positions[k]!;
    out[k + 1] = -positions[k + 2]!;
    out[k + 2] = positions[k + 1]!;
  }
  return out;
}
