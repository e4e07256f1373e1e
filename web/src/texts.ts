/** What an organiser starts from: texts for workers, to be changed. Markdown. */

/** A paragraph a line, as text areas break lines by themselves. */
const unwrapped = (text: string): string => text.replace(/(?<=[^\n])\n {0,3}(?=[^\s#\d-])/g, ' ');

/** What only the organiser knows: a collection isn't made while it stands there. */
export const consentGap = '[Who you are, where, and how to reach you.]';

export const consentText = unwrapped(`# About this study

*${consentGap}* We study how people describe ways through buildings, so that robots can
learn to follow what people say.

- You look at pictures of a building in your browser and write, or follow, directions. No part of your screen, no sound
  and no picture of you is recorded.
- We keep what you write, where you go and how you look in the building, how long you take, and the number by which we
  pay you. The directions and walks will be published, without that number.
- It is your choice. You can stop at any time by closing the page, and need not say why.

By pressing *I agree* you say that you are at least 18 years old and that you agree to this.
`);

const writeText = `# Write directions

A smart robot stands where the **green pole** is. It has never been in this building. Write directions so that it can find
the **red pole** from there.

1. Play the path, or go along it by the blue discs, and look around as you go.
2. Write what one should do, in the order of doing it, as you would tell a friend: *Leave the bedroom, turn left past the
   stairs and stop beside the sofa.*
3. Say what can be seen. The robot sees neither the poles nor the discs, and knows no compass, no metres and no seconds.
4. Where it should stop has to be clear from your words alone.

Full sentences or not, both are good. Do not copy from other paths.
`;

const walkText = `# Follow directions

You stand somewhere in a building. Somebody wrote how to get from here to a goal that you do not know.

1. Read the directions, look around, and walk by the rings on the floor.
2. You see what a robot would see: a view of a certain width, and only those rings that lie before you. Turn round for the others.
3. Where you think the goal is, press **Stop here**. You cannot walk on after that.

If you stop **less than 3 m** from the goal, this walk earns the bonus.
`;

export const instructionsText: Record<'write' | 'walk', string> = { write: unwrapped(writeText), walk: unwrapped(walkText) };
