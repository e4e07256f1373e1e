/** Animated GIFs (GIF89a): each frame with 256 colours of its own, chosen by median cut. */

export interface Frame {
  /** RGBA rows from the top. */
  readonly pixels: Uint8ClampedArray;
  readonly seconds: number;
}

const colours = 256;
const bins = 1 << 15; // five bits a channel
const binOf = (r: number, g: number, b: number): number => ((r >> 3) << 10) | ((g >> 3) << 5) | (b >> 3);
const channel = (bin: number, c: number): number => (bin >> (10 - 5 * c)) & 31;

/** Bins of colours that get one colour together. */
interface Box {
  readonly used: number[];
  readonly count: number;
  /** The channel that is widest, and how wide it is. */
  readonly widest: number;
  readonly range: number;
}

function boxOf(used: number[], counts: Uint32Array): Box {
  const ranges = [0, 1, 2].map((c) => {
    const values = used.map((bin) => channel(bin, c));
    return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b));
  });
  const range = Math.max(...ranges);
  return { used, count: used.reduce((sum, bin) => sum + counts[bin]!, 0), widest: ranges.indexOf(range), range };
}

/** In two, with as many pixels on both sides as can be. */
function split({ used, count, widest }: Box, counts: Uint32Array): [Box, Box] {
  used.sort((a, b) => channel(a, widest) - channel(b, widest));
  let [k, sum] = [1, counts[used[0]!]!];
  while (k < used.length - 1 && sum + counts[used[k]!]! / 2 < count / 2) sum += counts[used[k++]!]!;
  return [boxOf(used.slice(0, k), counts), boxOf(used.slice(k), counts)];
}

/** The colours of a picture, and for each bin which of them it gets. */
function paletteOf(pixels: Uint8ClampedArray): { table: Uint8Array; index: Uint8Array } {
  const counts = new Uint32Array(bins);
  const sums = new Float64Array(3 * bins);
  for (let k = 0; k < pixels.length; k += 4) {
    const bin = binOf(pixels[k]!, pixels[k + 1]!, pixels[k + 2]!);
    counts[bin]!++;
    for (let c = 0; c < 3; ++c) sums[3 * bin + c]! += pixels[k + c]!;
  }
  const boxes = [boxOf([...counts.keys()].filter((bin) => counts[bin]! > 0), counts)];
  while (boxes.length < colours) {
    const weight = ({ count, range }: Box) => range * Math.sqrt(count);
    const next = boxes.reduce((best, box, k) => (weight(box) > weight(boxes[best]!) ? k : best), 0);
    if (boxes[next]!.range === 0) break; // each has one bin
    boxes.push(...split(boxes.splice(next, 1)[0]!, counts));
  }
  const table = new Uint8Array(3 * colours);
  const index = new Uint8Array(bins);
  boxes.forEach(({ used, count }, k) => {
    for (const bin of used) index[bin] = k;
    for (let c = 0; c < 3; ++c) table[3 * k + c] = Math.round(used.reduce((sum, bin) => sum + sums[3 * bin + c]!, 0) / count);
  });
  return { table, index };
}

/** Compresses indices as GIF does (LZW, codes of 9 to 12 bits). */
function compress(indices: Uint8Array): number[] {
  const [clear, end, most] = [256, 257, 4096];
  const out: number[] = [];
  const codes = new Int16Array(most * 256); // the code of a code with an index behind it; 0: none
  let [next, size, held, bits] = [end + 1, 9, 0, 0];
  const write = (code: number): void => {
    held |= code << bits;
    for (bits += size; bits >= 8; bits -= 8, held >>>= 8) out.push(held & 255);
  };
  write(clear);
  let prefix = indices[0]!;
  for (let k = 1; k < indices.length; ++k) {
    const key = (prefix << 8) | indices[k]!;
    if (codes[key] !== 0) {
      prefix = codes[key]!;
      continue;
    }
    write(prefix);
    if (next < most) {
      codes[key] = next;
      if (next++ === 1 << size) ++size;
    } else {
      write(clear);
      codes.fill(0);
      [next, size] = [end + 1, 9];
    }
    prefix = indices[k]!;
  }
  write(prefix);
  // Reading it, a decoder has its next code one step later.
  if (next === 1 << size && size < 12) ++size;
  write(end);
  if (bits > 0) out.push(held & 255);
  return out;
}

const word = (value: number): number[] => [value & 255, value >> 8];
const text = (letters: string): number[] => [...letters].map((letter) => letter.charCodeAt(0));

function frameBytes({ pixels, seconds }: Frame, width: number, height: number): Uint8Array[] {
  const { table, index } = paletteOf(pixels);
  const indices = new Uint8Array(width * height);
  for (let k = 0; k < indices.length; ++k) indices[k] = index[binOf(pixels[4 * k]!, pixels[4 * k + 1]!, pixels[4 * k + 2]!)]!;
  const data = compress(indices);
  const blocks: Uint8Array[] = [];
  for (let at = 0; at < data.length; at += 255) {
    const block = data.slice(at, at + 255);
    blocks.push(Uint8Array.from([block.length, ...block]));
  }
  return [
    Uint8Array.from([0x21, 0xf9, 4, 0, ...word(Math.round(100 * seconds)), 0, 0]), // how long it stands
    Uint8Array.from([0x2c, ...word(0), ...word(0), ...word(width), ...word(height), 0x87]), table, // with its own 256 colours
    Uint8Array.from([8]), ...blocks, Uint8Array.from([0])];
}

/** A film that begins again at its end. @param frames at least one; all of that size */
export function encodeGif(width: number, height: number, frames: readonly Frame[]): Blob {
  const head = [...text('GIF89a'), ...word(width), ...word(height), 0, 0, 0, 0x21, 0xff, 11, ...text('NETSCAPE2.0'), 3, 1, 0, 0, 0];
  const parts = [Uint8Array.from(head), ...frames.flatMap((frame) => frameBytes(frame, width, height)), Uint8Array.from([0x3b])];
  return new Blob(parts as BlobPart[], { type: 'image/gif' });
}
