import { describe, expect, it } from 'vitest';
import { parseGlb } from './glb.ts';

/** A file of one triangle, as enfilade/mesh/write_mesh.cpp lays it out. */
function file(change: (gltf: Record<string, unknown>) => void = () => {}): ArrayBuffer {
  const numbers = new Float32Array([0, 2, -1, 1, 2, -1, 0, 2, -4, 0, 0, 1, 0, 0, 1, 0.5, 0.5, 0.5, 1, 1, 1, 2, 2, 2]);
  const indices = new Uint32Array([0, 1, 2]);
  const picture = new Uint8Array([0x89, 0x50, 0x4e, 0x47]);
  const gltf: Record<string, unknown> = {
    asset: { version: '2.0' }, nodes: [{ name: 'building', mesh: 0 }, { name: 'empty' }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1, COLOR_0: 2 }, indices: 3, material: 1 }] }],
    accessors: [
      { bufferView: 0, byteOffset: 0, componentType: 5126, count: 3, type: 'VEC3' },
      { bufferView: 1, byteOffset: 0, componentType: 5126, count: 3, type: 'VEC2' },
      { bufferView: 2, byteOffset: 0, componentType: 5126, count: 3, type: 'VEC3' },
      { bufferView: 3, byteOffset: 0, componentType: 5125, count: 3, type: 'SCALAR' },
    ],
    bufferViews: [
      { byteOffset: 0, byteLength: 36, byteStride: 12 }, { byteOffset: 36, byteLength: 24, byteStride: 8 },
      { byteOffset: 60, byteLength: 36, byteStride: 12 }, { byteOffset: 96, byteLength: 12 }, { byteOffset: 108, byteLength: 4 },
    ],
    materials: [{ name: 'plain' }, {
      pbrMetallicRoughness: { baseColorFactor: [0.2, 0.4, 0.6, 1], baseColorTexture: { index: 0 } }, alphaMode: 'MASK', alphaCutoff: 0.25,
    }],
    textures: [{ source: 0 }], images: [{ bufferView: 4, mimeType: 'image/png' }],
  };
  change(gltf);
  let text = new TextEncoder().encode(JSON.stringify(gltf));
  text = new Uint8Array([...text, ...Array<number>((4 - (text.length % 4)) % 4).fill(0x20)]);
  const binary = new Uint8Array([...new Uint8Array(numbers.buffer), ...new Uint8Array(indices.buffer), ...picture]);
  const out = new ArrayBuffer(28 + text.length + binary.length);
  const view = new DataView(out);
  [0x46546c67, 2, out.byteLength, text.length, 0x4e4f534a].forEach((word, k) => view.setUint32(4 * k, word, true));
  new Uint8Array(out).set(text, 20);
  view.setUint32(20 + text.length, binary.length, true);
  view.setUint32(24 + text.length, 0x004e4942, true);
  new Uint8Array(out).set(binary, 28 + text.length);
  return out;
}

describe('a binary glTF file', () => {
  it('becomes triangles with z up, their light and their material', async () => {
    const { parts, materials } = parseGlb(file());
    expect(parts).toHaveLength(1);
    const [part] = parts;
    expect(part).toMatchObject({ name: 'building', material: 1 });
    expect([...part!.positions]).toEqual([0, 1, 2, 1, 1, 2, 0, 4, 2]);
    expect([...part!.indices]).toEqual([0, 1, 2]);
    expect([...part!.texturePoints!]).toEqual([0, 0, 1, 0, 0, 1]);
    expect([...part!.light!]).toEqual([0.5, 0.5, 0.5, 1, 1, 1, 2, 2, 2]);
    expect(materials[0]).toEqual({ colour: [1, 1, 1], cutoff: 0 });
    expect(materials[1]).toMatchObject({ colour: [0.2, 0.4, 0.6], cutoff: 0.25 });
    expect(new Uint8Array(await materials[1]!.picture!.arrayBuffer())).toEqual(new Uint8Array([0x89, 0x50, 0x4e, 0x47]));
  });

  it('is refused where it is cut off, or is something else', () => {
    const whole = file();
    expect(() => parseGlb(new ArrayBuffer(4))).toThrow('no binary glTF');
    expect(() => parseGlb(new TextEncoder().encode('{"error": {"code": "not-found"}} and more').buffer)).toThrow('no binary glTF');
    expect(() => parseGlb(whole.slice(0, whole.byteLength - 8))).toThrow('cut off');
    expect(() => parseGlb(whole.slice(0, 200))).toThrow('cut off');
    expect(() => parseGlb(file((gltf) => { (gltf['accessors'] as { count: number }[])[0]!.count = 30; }))).toThrow('cut off');
    expect(() => parseGlb(file((gltf) => { (gltf['accessors'] as { componentType: number }[])[3]!.componentType = 5123; }))).toThrow('another kind');
  });
});
