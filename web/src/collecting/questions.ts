/** Questions to workers as an organiser types them: a block each, its choices on lines of their own, a star before the right ones. */

interface AskedQuestion {
  readonly question: string;
  readonly choices: readonly string[];
  /** The right ones. */
  readonly accept: readonly string[];
}

/** @throws Error that names the block which is no question */
export function parseQuestions(text: string): AskedQuestion[] {
  const blocks = text.split(/\n\s*\n/).map((block) => block.split('\n').map((line) => line.trim()).filter((line) => line !== ''));
  return blocks.filter((lines) => lines.length > 0).map((lines, k) => {
    const [question = '', ...rest] = lines;
    const choices = rest.map((line) => line.replace(/^\*\s*/, ''));
    const accept = choices.filter((_, at) => rest[at]!.startsWith('*'));
    if (choices.length < 2) throw new Error(`Question ${k + 1}, "${question}": write two choices at least, each on its own line.`);
    if (accept.length === 0) throw new Error(`Question ${k + 1}, "${question}": put a * before each right choice.`);
    return { question, choices, accept };
  });
}
