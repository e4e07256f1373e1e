/** Speaking instead of typing, in browsers that can turn speech into text. */

interface Result { readonly isFinal: boolean; readonly [k: number]: { readonly transcript: string } }
interface Heard { readonly resultIndex: number; readonly results: ArrayLike<Result> }
interface Recognition {
  lang: string;
  continuous: boolean;
  interimResults: boolean;
  onresult: ((heard: Heard) => void) | null;
  onspeechstart: (() => void) | null;
  onerror: ((event: { error: string }) => void) | null;
  onend: (() => void) | null;
  start(): void;
  stop(): void;
}
type Maker = new () => Recognition;

/** Nothing where the browser has none. */
function maker(): Maker | undefined {
  const all = globalThis as { SpeechRecognition?: Maker; webkitSpeechRecognition?: Maker };
  return all.SpeechRecognition ?? all.webkitSpeechRecognition;
}

export const canSpeak = (): boolean => maker() !== undefined;

/** Listens until it is stopped. */
export class Speech {
  private readonly recognition: Recognition;
  private running = false;
  private since = 0;

  /**
   * @param now seconds
   * @param hear gets what was said, and when that began
   * @param changed called when listening begins or ends; with an error, why it could not
   */
  constructor(language: string, now: () => number, hear: (text: string, since: number) => void, changed: (problem?: string) => void) {
    this.recognition = new (maker()!)();
    this.recognition.lang = language;
    this.recognition.continuous = true;
    this.recognition.interimResults = true;
    this.recognition.onspeechstart = () => { this.since = now(); };
    this.recognition.onresult = ({ resultIndex, results }) => {
      for (let k = resultIndex; k < results.length; ++k) {
        const result = results[k]!;
        if (!result.isFinal) continue;
        hear(result[0]!.transcript.trim(), this.since);
        this.since = now();
      }
    };
    this.recognition.onerror = ({ error }) => changed(error === 'no-speech' ? undefined : error);
    this.recognition.onend = () => {
      this.running = false;
      changed();
    };
    this.begin = () => {
      this.since = now();
      this.running = true;
      this.recognition.start();
      changed();
    };
  }

  readonly begin: () => void;

  get listening(): boolean {
    return this.running;
  }

  stop(): void {
    if (this.running) this.recognition.stop();
  }
}
