/**
 * One tab at a time. Two that show the same task would overwrite each other's text, so the newest goes on, and the others
 * save what they have and stop.
 */

interface Message {
  readonly from: string;
  readonly say: 'opened' | 'here' | 'saved';
  readonly to?: string;
}

/** Milliseconds: another tab answers at once, if there is one. */
const answerMs = 200;
/** Until another tab has saved its text; then this one goes on without it. */
const saveMs = 3000;

export class Tabs {
  // Not randomUUID(), which pages without TLS do not have.
  private readonly id = crypto.getRandomValues(new Uint32Array(4)).join('-');
  private readonly channel: BroadcastChannel | undefined;
  private heard: (message: Message) => void = () => {};

  /** @param visit names what only one tab may work at */
  constructor(visit: string) {
    try {
      this.channel = new BroadcastChannel(`enfilade/${visit}`);
      this.channel.addEventListener('message', ({ data }: MessageEvent<Message>) => this.heard(data));
    } catch {
      // Blocked, as in some frames: then the server's rules alone protect the text.
    }
  }

  /** Stops the other tabs. Resolves once they have saved, with whether there was one. */
  takeOver(): Promise<boolean> {
    const { channel } = this;
    if (!channel) return Promise.resolve(false);
    return new Promise((resolve) => {
      let timer = setTimeout(() => resolve(false), answerMs);
      this.heard = ({ say, to }) => {
        if (to !== this.id) return;
        clearTimeout(timer);
        if (say === 'saved') resolve(true);
        else timer = setTimeout(() => resolve(true), saveMs);
      };
      this.say({ from: this.id, say: 'opened' });
    });
  }

  /** From now on this tab makes room for a newer one. @param save is waited for */
  giveWay(save: () => Promise<void>): void {
    this.heard = ({ from, say }) => {
      if (say !== 'opened') return;
      this.heard = () => {};
      this.say({ from: this.id, say: 'here', to: from });
      void save().catch(() => {}).then(() => this.say({ from: this.id, say: 'saved', to: from }));
    };
  }

  private say(message: Message): void {
    this.channel?.postMessage(message);
  }
}
