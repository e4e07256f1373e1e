import { describe, expect, it } from 'vitest';
import { shownText } from './episode.ts';

describe('an instruction for people', () => {
  it('has the words of a dialogue in place of its tags', () => {
    expect(shownText('<TAR> picture', 'cvdn')).toBe('Looking for: picture');
    expect(shownText('<NAV> Left or right? <ORA> Left, at <b>it</b>. <TAR> chair', 'cvdn'))
      .toBe('Navigator: Left or right?\nOracle: Left, at <b>it</b>.\nLooking for: chair');
    expect(shownText('', 'cvdn')).toBe('');
  });

  it('breaks the line where two instructions were joined without a blank', () => {
    expect(shownText('Go on and wait there.Continue ahead.', 'r4r')).toBe('Go on and wait there.\nContinue ahead.');
    expect(shownText('Wait thereTurn left', 'r4r')).toBe('Wait there\nTurn left');
    expect(shownText('Stop by the TV (on the left).A door is ahead.', 'r4r')).toBe('Stop by the TV (on the left).\nA door is ahead.');
    const whole = 'Pass the "Exit" sign of the U.S. office. Wait at 3.5 m, by the TV.';
    expect(shownText(whole, 'r4r')).toBe(whole);
  });

  it('is as it is elsewhere', () => {
    const text = 'Go on.Continue <TAR> ahead';
    expect(shownText(text, 'r2r')).toBe(text);
    expect(shownText(text, undefined)).toBe(text);
  });
});
