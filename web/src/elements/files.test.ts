import { gzipSync } from 'node:zlib';
import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { textOf } from './files.ts';

describe('a chosen file', () => {
  const text = '[{"instr_id": "1_0", "é": "€"}]';
  const zeros = new Uint8Array(700);
  const packed = (part: string) => new Uint8Array(gzipSync(part));

  // Browsers' takes one member, and no bytes behind it; that of Node.js takes several.
  beforeAll(() => {
    vi.stubGlobal('DecompressionStream', class {
      constructor() {
        throw new TypeError('this one is for files of one member');
      }
    });
  });
  afterAll(() => void vi.unstubAllGlobals());

  it('is read plain and packed, with a byte-order mark or without', async () => {
    for (const saved of [text, `\uFEFF${text}`]) {
      expect(await textOf(new Blob([saved]))).toBe(text);
      expect(await textOf(new Blob([packed(saved)]))).toBe(text);
    }
    for (const short of ['', '1']) expect(await textOf(new Blob([short]))).toBe(short);
  });

  it('may have several members, with zeros between and behind them', async () => {
    const halves = [packed(text.slice(0, 9)), packed(text.slice(9))] as const;
    expect(await textOf(new Blob([...halves]))).toBe(text);
    expect(await textOf(new Blob([...halves, zeros]))).toBe(text);
    expect(await textOf(new Blob([halves[0], zeros, halves[1]]))).toBe(text);
    expect(await textOf(new Blob([packed(''), ...halves, packed('')]))).toBe(text);
  });

  it('is whole where it and its members are long', async () => {
    for (const length of [65_535, 65_536, 65_537, 300_000]) { // pako's pieces have 65,536 bytes
      const long = 'ab'.repeat(length).slice(0, length);
      expect(await textOf(new Blob([packed(long), packed(long)])) === long + long, `${length} bytes`).toBe(true);
    }
  });

  it('is refused if it is damaged', async () => {
    const whole = packed(text);
    const wrong = whole.slice();
    wrong[whole.length - 8]! ^= 1; // of the checksum
    const damaged = [[whole.slice(0, -9)], [wrong], [whole, whole.slice(0, -9)], [whole, 'more'], [whole, zeros, 'more']];
    for (const parts of damaged) await expect(textOf(new Blob(parts))).rejects.toThrow('damaged gzip');
  });
});
