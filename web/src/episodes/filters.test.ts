import { describe, expect, it } from 'vitest';
import { formatFilters, parseFilters } from './filters.ts';

const splits = ['train', 'val_seen'];

describe('filters in an address', () => {
  it('come back as they were', () => {
    const filters = { split: 'val_seen', scan: 'a/b?c', words: 'turn "left" & stop', order: 'error-down', outcome: 'failed', offset: 50 } as const;
    expect(parseFilters(formatFilters(filters), splits)).toEqual(filters);
  });

  it('leave out what needs no saying', () => {
    expect(formatFilters(parseFilters('', splits))).toBe('?split=train');
  });

  it.each(['?split=nowhere', '?sort=upwards&outcome=x', '?offset=-5', '?offset=1.5', '?offset=x', '?offset=1e99'])('take no harm from %s', (search) => {
    expect(parseFilters(search, splits)).toEqual({ split: 'train', scan: '', words: '', order: 'file', outcome: 'all', offset: 0 });
  });

  it('know a data set without splits', () => {
    expect(parseFilters('?split=train', []).split).toBe('');
  });
});
