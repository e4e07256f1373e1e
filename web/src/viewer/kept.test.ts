import { describe, expect, it } from 'vitest';
import { Kept } from './kept.ts';

describe('a cache', () => {
  const make = () => {
    const log: string[] = [];
    const kept = new Kept(2, async (key) => {
      log.push(`fetch ${key}`);
      if (key === 'broken') throw new Error(key);
      return { key, dispose: () => log.push(`drop ${key}`) };
    });
    return { log, kept };
  };

  it('fetches once, and drops what was used longest ago', async () => {
    const { log, kept } = make();
    await Promise.all([kept.get('a'), kept.get('a'), kept.get('b')]);
    await kept.get('a');
    await kept.get('c');
    await Promise.resolve();
    expect(log).toEqual(['fetch a', 'fetch b', 'fetch c', 'drop b']);
  });

  it('tries again what failed', async () => {
    const { log, kept } = make();
    await expect(kept.get('broken')).rejects.toThrow('broken');
    await Promise.resolve();
    await expect(kept.get('broken')).rejects.toThrow('broken');
    expect(log).toEqual(['fetch broken', 'fetch broken']);
  });
});
