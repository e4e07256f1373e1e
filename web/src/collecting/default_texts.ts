/** What an organiser starts from: texts for workers, to be changed. Markdown. */
import type { Kind } from './collections.ts';

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
3. Say what can be seen. The robot sees neither the poles nor the discs, and has no compass, no measure and no clock.
   At first it may look in any direction: begin with what stands there, not with left or right.
4. Where it should stop has to be clear from your words alone.

Full sentences or not, both are good. Do not copy from other paths.
`;

const walkText = `# Follow directions

You stand somewhere in a building. Another person wrote how to get from here to a goal that you do not know.

1. Read the directions, look around, and walk by the rings on the floor.
2. You see what a robot would see: a view of a certain width, and only those rings that lie before you. Turn round for the others.
3. Where you think the goal is, press **Stop here**. You cannot walk on after that.

If you stop **less than 3 m** from the goal, this walk earns the bonus.
`;

const describeText = `# Describe an object

A smart robot stands where the **green pole** is. It has never been in this building. A person wants it to do something with
the object in the **orange frame**, at the end of the path.

1. Play the path, or go along it, and look at the object in its frame.
2. Write what the robot should do with it, and how to know it: *Go to the bathroom upstairs and turn off the lamp beside the mirror.*
3. Say which room it is in and what stands near it. You need not say every turn of the way.
4. The robot sees no frame, no poles and no discs. There may be several such things: it has to be clear which one you mean.
`;

const findText = `# Find an object

You stand somewhere in a building. Another person wrote what should be done with an object that you do not see yet.

1. Read it, look around, and walk by the rings on the floor until you see the object.
2. Press **I see the object**, and click on it in the picture. By keys: turn until it is in the middle, and press *Point at the middle*.
3. Press **Yes, this is the object**. You cannot go on after that.

If it is the right object, this task earns the bonus.
`;

const guideText = `# Guide another person

A person who has never been here will walk this path by your words alone, and hear them as you say them.

1. Walk from the **green pole** to the **red pole**, by the blue discs or the buttons.
2. Say on the way what one should do, and what one sees just then. Type it, or speak, if your browser can write down speech.
3. Say nothing of poles and discs: no one else sees them. Where it ends has to be clear from your words.

The page records where you look, and when you say each word.
`;

const dialogueText = `# Find it together

Two people work together, each at a page of their own. The **navigator** walks through the building and looks for a thing. The
**oracle** sees the next steps of the shortest way, and answers questions.

1. The navigator walks, and asks when it is not clear where to go. While the oracle answers, the navigator waits.
2. The oracle sees what the navigator sees, and the way as blue discs. Say it in words: the navigator sees no discs of the way.
3. The navigator stops where the thing is, and the dialogue ends for both.

Be friendly, and write nothing about yourself.
`;

export const instructionsText: Record<Kind, string> = {
  write: unwrapped(writeText), walk: unwrapped(walkText), describe: unwrapped(describeText), find: unwrapped(findText),
  guide: unwrapped(guideText), dialogue: unwrapped(dialogueText),
};
