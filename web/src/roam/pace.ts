/** How large a moving picture is drawn: where frames come too slowly, with fewer pixels. */

/** Milliseconds between two frames: longer ones are too slow, 18 a second; shorter ones leave time for more pixels. */
const slow = 55;
const quick = 22;
/** What is aimed at when the picture becomes smaller. */
const aim = 45;
/** Frames that are looked at before it shrinks or grows: one slow frame alone means nothing. */
const few = 3;
const many = 30;
const growth = 1.2;

const median = (values: readonly number[]): number => [...values].sort((a, b) => a - b)[values.length >> 1]!;

export class Pace {
  private size: number;
  private readonly least: number;
  private most = 1;
  private grown = false;
  private frames: number[] = [];

  /** @param least of the scale @param first the scale to begin with */
  constructor(least: number, first = 1) {
    [this.least, this.size] = [least, first];
  }

  /** The share of the picture's width and height, 0 to 1. */
  get scale(): number {
    return this.size;
  }

  /** In a motion a frame came so long after the one before, milliseconds. */
  took(milliseconds: number): void {
    this.frames.push(milliseconds);
    const recent = this.frames.slice(-few);
    if (recent.length === few && median(recent) > slow) {
      if (this.grown) this.most = this.size / growth; // it was too much: never again
      this.grown = false;
      this.resize(this.size * Math.sqrt(aim / median(recent))); // time goes with the pixels
    } else if (this.frames.length >= many) {
      this.grown = median(this.frames) < quick && this.size < this.most;
      this.resize(this.grown ? this.size * growth : this.size);
    }
  }

  private resize(scale: number): void {
    this.size = Math.min(Math.max(scale, this.least), this.most);
    this.frames = [];
  }
}
