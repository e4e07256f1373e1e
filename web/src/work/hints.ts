/** What is said of directions before they are submitted: advice, and why a text that is too short is refused. */

/** How directions came about. */
export interface Behaviour {
  /** Characters that were pasted, not typed. */
  readonly pasted: number;
  /** The worker looked around at the goal. */
  readonly goalSeen: boolean;
}

export interface Hint {
  /** The server keeps the codes of those that were passed over, for review. */
  readonly code: 'short' | 'pasted' | 'goal-not-seen';
  readonly text: string;
}

/** One of 600 instructions of R2R has fewer: 36 of the 21,582 in its four files. */
const fewWords = 6;
/** A word or two may be moved about; whole sentences of others may not. */
const muchPasted = 40;

export const wordsIn = (text: string): number =>
  text.split(/\s+/).filter((word) => /[\p{L}\p{N}]/u.test(word)).length;

/** The server's rule: characters and words. */
const [leastCharacters, leastWords] = [10, 3];

/** Why directions are refused; nothing if they are long enough. */
export function tooShort(text: string): string | undefined {
  const trimmed = text.trim();
  const words = trimmed === '' ? 0 : trimmed.split(/\s+/).length;
  if (words >= leastWords && trimmed.length >= leastCharacters) return undefined;
  if (words === 0) return 'Write the directions here first.';
  return `This is too short to lead anybody: write at least ${leastWords} words, and ${leastCharacters} letters in all.`;
}

export function hintsFor(text: string, { pasted, goalSeen }: Behaviour): Hint[] {
  const hints: Hint[] = [];
  if (wordsIn(text) < fewWords) {
    hints.push({ code: 'short', text: 'This is very short. Would a robot that has never been here find the goal with it?' });
  }
  if (pasted >= muchPasted) {
    hints.push({ code: 'pasted', text: 'Part of this was pasted. Does it describe this very path, in your own words?' });
  }
  if (!goalSeen) {
    hints.push({ code: 'goal-not-seen', text: 'You have not looked around at the goal. What stands there tells a robot where to stop.' });
  }
  return hints;
}
