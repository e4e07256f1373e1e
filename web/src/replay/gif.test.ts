import { describe, expect, it } from 'vitest';
import { random } from '../testing/random.ts';
import { encodeGif, type Frame } from './gif.ts';

interface Decoded {
  readonly width: number;
  readonly height: number;
  readonly loops: boolean;
  readonly frames: { seconds: number; pixels: number[] }[];
}

/** Codes of GIF's LZW, as its specification reads them. */
function expand(data: readonly number[], least: number): number[] {
  const [clear, end] = [1 << least, (1 << least) + 1];
  let table: number[][] = [];
  let [size, held, bits, at] = [least + 1, 0, 0, 0];
  let before: number[] | undefined;
  const out: number[] = [];
  for (;;) {
    while (bits < size) {
      held |= data[at++]! << bits;
      bits += 8;
    }
    const code = held & ((1 << size) - 1);
    held >>>= size;
    bits -= size;
    if (code === end) return out;
    if (code === clear) {
      table = Array.from({ length: end + 1 }, (_, k) => (k < clear ? [k] : []));
      size = least + 1;
      before = undefined;
      continue;
    }
    const known = table[code];
    if (!known && (!before || code !== table.length)) throw new Error(`code ${code} of ${table.length}`);
    const entry: number[] = known ?? [...before!, before![0]!];
    out.push(...entry);
    if (before && table.length < 4096) table.push([...before, entry[0]!]);
    if (table.length === 1 << size && size < 12) ++size;
    before = entry;
  }
}

function decode(bytes: Uint8Array): Decoded {
  let at = 0;
  const byte = () => bytes[at++]!;
  const word = () => byte() | (byte() << 8);
  const take = (count: number) => [...bytes.subarray(at, at += count)];
  const blocks = () => {
    const all: number[] = [];
    for (let size = byte(); size > 0; size = byte()) all.push(...take(size));
    return all;
  };
  expect(String.fromCharCode(...take(6))).toBe('GIF89a');
  const [width, height] = [word(), word()];
  expect(take(3)).toEqual([0, 0, 0]);
  const frames: Decoded['frames'] = [];
  let [seconds, loops] = [0, false];
  for (;;) {
    const kind = byte();
    if (kind === 0x3b) break;
    if (kind === 0x21) {
      const label = byte();
      const data = blocks();
      if (label === 0xf9) seconds = (data[1]! | (data[2]! << 8)) / 100;
      else loops = String.fromCharCode(...data.slice(0, 11)) === 'NETSCAPE2.0' && data[12] === 0 && data[13] === 0;
      continue;
    }
    expect(kind).toBe(0x2c);
    expect([word(), word(), word(), word()]).toEqual([0, 0, width, height]);
    const flags = byte();
    expect(flags & 0x80).toBe(0x80);
    const table = take(3 * (2 << (flags & 7)));
    expect(byte()).toBe(8);
    const indices = expand(blocks(), 8);
    expect(indices).toHaveLength(width * height);
    frames.push({ seconds, pixels: indices.flatMap((k) => table.slice(3 * k, 3 * k + 3)) });
  }
  expect(at).toBe(bytes.length);
  return { width, height, loops, frames };
}

const rgba = (colours: readonly (readonly number[])[]): Uint8ClampedArray =>
  Uint8ClampedArray.from(colours.flatMap(([r, g, b]) => [r!, g!, b!, 255]));
const rgb = ({ pixels }: Frame): number[] => [...pixels].filter((_, k) => k % 4 !== 3);
const bytesOf = async (blob: Blob): Promise<Uint8Array> => new Uint8Array(await blob.arrayBuffer());

describe('an animated GIF', () => {
  it('has each pixel as it was where there are few colours, over several frames', async () => {
    const palette = [[0, 0, 0], [255, 255, 255], [200, 16, 16], [16, 120, 240]];
    const frame = (seed: number, seconds: number): Frame => {
      const next = random(seed);
      return { pixels: rgba(Array.from({ length: 31 * 17 }, () => palette[Math.floor(next() * 4)]!)), seconds };
    };
    const frames = [frame(1, 1.25), frame(2, 0.5)];
    const blob = encodeGif(31, 17, frames);
    expect(blob.type).toBe('image/gif');
    const decoded = decode(await bytesOf(blob));
    expect([decoded.width, decoded.height, decoded.loops]).toEqual([31, 17, true]);
    expect(decoded.frames.map(({ seconds }) => seconds)).toEqual([1.25, 0.5]);
    expect(decoded.frames.map(({ pixels }) => pixels)).toEqual(frames.map(rgb));
  });

  it('is read back where the codes grow to their longest and begin anew', async () => {
    // 250 colours in bins of their own, in no order: more than 4,096 codes.
    const next = random(3);
    const colours = Array.from({ length: 250 }, (_, k) => [8 * (k % 32), 8 * Math.floor(k / 32) + 4, 100]);
    const frame: Frame = { pixels: rgba(Array.from({ length: 200 * 150 }, () => colours[Math.floor(next() * colours.length)]!)), seconds: 1 };
    const [decoded] = decode(await bytesOf(encodeGif(200, 150, [frame]))).frames;
    expect(decoded!.pixels).toEqual(rgb(frame));
  });

  it('is read back at every length of codes at its end', async () => {
    const next = random(4);
    const colours = Array.from({ length: 200 }, (_, k) => [8 * (k % 32), 8 * Math.floor(k / 32), 8]);
    for (let count = 1; count < 700; count += count < 240 || count > 270 ? 23 : 1) {
      const frame: Frame = { pixels: rgba(Array.from({ length: count }, () => colours[Math.floor(next() * 200)]!)), seconds: 0.1 };
      expect(decode(await bytesOf(encodeGif(count, 1, [frame]))).frames[0]!.pixels, `${count} pixels`).toEqual(rgb(frame));
    }
  });

  it('is near to a picture of many colours', async () => {
    const [width, height] = [128, 96];
    const pixels = rgba(Array.from({ length: width * height }, (_, k) => {
      const [x, y] = [k % width, Math.floor(k / width)];
      return [2 * x, Math.round(2.6 * y), Math.round(127 + 127 * Math.sin((x + y) / 20))];
    }));
    const [decoded] = decode(await bytesOf(encodeGif(width, height, [{ pixels, seconds: 1 }]))).frames;
    const errors = rgb({ pixels, seconds: 1 }).map((value, k) => Math.abs(value - decoded!.pixels[k]!));
    expect(errors.reduce((a, b) => a + b) / errors.length).toBeLessThan(8);
    expect(Math.max(...errors)).toBeLessThan(64);
  });
});
