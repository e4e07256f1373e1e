/** A run's steps as an animated GIF, for papers: what the model saw, or the view at its pose, with the instruction and the action. */
import { shownText } from '../episodes/episode.ts';
import { reach } from '../server/api.ts';
import { encodeGif, type Frame } from './gif.ts';
import { endText, outcomeWords } from './runs.ts';
import type { RunPanel } from './run_panel.ts';

const width = 640;
/** The view's, where the model saw no strip. */
const viewHeight = 400;
const line = 18;
const border = 10;
const stepSeconds = 1.5;
const endSeconds = 4;

type Context = CanvasRenderingContext2D;

/** A text in lines that fit; the last one ends with an ellipsis where more follows. */
function linesOf(context: Context, text: string, most: number): string[] {
  const lines: string[] = [''];
  for (const one of text.split(/\s+/)) {
    const longer = `${lines.at(-1)} ${one}`.trim();
    if (context.measureText(longer).width <= width - 2 * border || lines.at(-1) === '') lines[lines.length - 1] = longer;
    else if (lines.length < most) lines.push(one);
    else {
      lines[most - 1] += ' …';
      break;
    }
  }
  return lines;
}

const fontOf = (weight: string): string => `${weight} 13px sans-serif`;

/** Draws words under the picture. */
function write(context: Context, top: number, instruction: readonly string[], said: readonly string[]): void {
  context.fillStyle = '#ffffff';
  context.fillRect(0, top, width, context.canvas.height - top);
  context.textBaseline = 'middle';
  const row = (text: string, k: number, colour: string, weight: string) => {
    context.fillStyle = colour;
    context.font = fontOf(weight);
    context.fillText(text, border, top + border + line * (k + 0.5));
  };
  instruction.forEach((text, k) => row(text, k, '#5a5f68', '400'));
  said.forEach((text, k) => row(text, instruction.length + k, '#191c22', '700'));
}

async function fetched(address: string): Promise<ImageBitmap> {
  const response = await reach(address);
  if (!response.ok) throw new Error(`a picture that the model saw is not there: status ${response.status}`);
  return createImageBitmap(await response.blob());
}

/** The view at the pose that the panel shows, without letters. */
async function captured(panel: RunPanel): Promise<ImageBitmap> {
  const pixels = panel.viewer!.capture(width, viewHeight);
  return createImageBitmap(new ImageData(new Uint8ClampedArray(pixels), width, viewHeight));
}

/** Whether there is anything to make one of. */
export const canBeFilmed = ({ replay, viewer }: RunPanel): boolean => showsStrips(replay) || viewer !== undefined;

/** Whether each step has the one strip that the model saw. */
const showsStrips = ({ steps }: RunPanel['replay']): boolean =>
  steps.length > 0 && steps.every(({ pictures }) => pictures?.length === 1 && pictures[0] === '');

/**
 * Shows each step in the panel meanwhile, where its view is needed.
 * @param tell how far it is: the step that is drawn, and how many there are
 */
export async function filmOf(panel: RunPanel, tell: (step: number, all: number) => void): Promise<Blob> {
  const { replay } = panel;
  const strips = showsStrips(replay);
  const pictureHeight = strips ? width / 4 : viewHeight;
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d', { willReadFrequently: true })!;
  context.font = fontOf('400');
  const instruction = linesOf(context, shownText(replay.instruction, replay.task), 4);
  const ending = `It ${endText(replay.end)}. ${outcomeWords(replay)}`;
  context.font = fontOf('700');
  const endLines = linesOf(context, ending, 3);
  canvas.width = width;
  canvas.height = pictureHeight + 2 * border + line * (instruction.length + endLines.length);
  const frames: Frame[] = [];
  for (let number = 1; number <= panel.length; ++number) {
    tell(number, panel.length);
    const isEnd = number === panel.length;
    if (!strips) await panel.show(number);
    // At the end nothing more was seen: the last picture stays.
    const picture = strips ? await fetched(panel.pictures(Math.min(number, panel.length - 1))[0]!) : await captured(panel);
    context.drawImage(picture, 0, 0, width, pictureHeight);
    picture.close();
    write(context, pictureHeight, instruction, isEnd ? endLines : [`Step ${number} of ${panel.length - 1}: ${panel.title(number)}`]);
    frames.push({ pixels: context.getImageData(0, 0, canvas.width, canvas.height).data, seconds: isEnd ? endSeconds : stepSeconds });
    await new Promise((resolve) => setTimeout(resolve)); // so that the page stays usable
  }
  return encodeGif(canvas.width, canvas.height, frames);
}
