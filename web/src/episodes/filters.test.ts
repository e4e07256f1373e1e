import { describe, expect, it } from 'vitest';
import { formatFilters, isServersList, narrowing, parseFilters } from './filters.ts';

const splits = ['train', 'val_seen'];

describe('filters in an address', () => {
  it('come back as they were', () => {
    const chosen = { scan: 'a/b?c', words: 'turn "left" & stop', order: 'error-down', outcome: 'failed' } as const;
    const filters = { split: 'val_seen', ...chosen, offset: 50 };
    expect(parseFilters(formatFilters(filters), splits)).toEqual(filters);
  });

  it('leave out what needs no saying', () => {
    expect(formatFilters(parseFilters('', splits))).toBe('?split=train');
  });

  it.each(['?split=nowhere', '?sort=upwards&outcome=x', '?offset=-5', '?offset=1.5', '?offset=x', '?offset=1e99'])('take no harm from %s', (search) => {
    expect(parseFilters(search, splits)).toEqual({ split: 'train', scan: '', words: '', order: 'file', outcome: 'all', offset: 0 });
  });

  it('go with an episode into its address, but for the page of the list', () => {
    const filters = parseFilters('?split=val_seen&q=turn+left&sort=longest&offset=50', splits);
    expect(narrowing(filters)).toEqual({ q: 'turn left', sort: 'longest' });
    expect(isServersList(filters)).toBe(false);
    expect(isServersList(parseFilters('?q=turn', splits))).toBe(true);
    expect(isServersList(parseFilters('?outcome=failed', splits))).toBe(false);
  });

  it('know a data set without splits', () => {
    expect(parseFilters('?split=train', []).split).toBe('');
  });
});
