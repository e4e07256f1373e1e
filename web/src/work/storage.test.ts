import { describe, expect, it } from 'vitest';
import { openStorage } from './storage.ts';

describe('storage', () => {
  it('is the page\'s memory where the browser gives none', () => {
    const storage = openStorage(() => { throw new DOMException('denied', 'SecurityError'); });
    expect(storage.lasting).toBe(false);
    storage.setItem('a', '1');
    expect(storage.getItem('a')).toBe('1');
    storage.removeItem('a');
    expect(storage.getItem('a')).toBeNull();
  });
  it('is the browser\'s where there is one', () => {
    const kept = new Map<string, string>();
    const browser = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value), removeItem: (key: string) => void kept.delete(key) };
    const storage = openStorage(() => browser as Storage);
    storage.setItem('a', '1');
    expect(storage.lasting).toBe(true);
    expect([...kept]).toEqual([['a', '1']]);
  });
});
