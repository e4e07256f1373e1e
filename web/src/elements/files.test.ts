import { gzipSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';
import { textOf } from './files.ts';

describe('a chosen file', () => {
  const text = '[{"instr_id": "1_0", "é": "€"}]';

  it('is read plain and packed, with a byte-order mark or without', async () => {
    for (const saved of [text, `\uFEFF${text}`]) {
      expect(await textOf(new Blob([saved]))).toBe(text);
      expect(await textOf(new Blob([new Uint8Array(gzipSync(saved))]))).toBe(text);
    }
    for (const short of ['', '1']) expect(await textOf(new Blob([short]))).toBe(short);
  });

  it('is refused if it is damaged', async () => {
    const packed = new Uint8Array(gzipSync(text));
    await expect(textOf(new Blob([packed.slice(0, -9)]))).rejects.toThrow();
  });
});
