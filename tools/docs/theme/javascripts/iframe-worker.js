// The search runs in a worker, and browsers start none from file:// addresses. There, a hidden frame stands in
// for it. (Material's own replacement is fetched from the network.)
if (location.protocol === 'file:') {
  window.Worker = window.IFrameWorker = class extends EventTarget {
    #frame = document.createElement('iframe');
    #waiting = [];
    #ready = false;

    constructor(address) {
      super();
      this.#frame.hidden = true;
      this.#frame.srcdoc = '<!doctype html>';
      this.#frame.addEventListener('load', () => this.#start(String(new URL(address, document.baseURI))), { once: true });
      document.body.append(this.#frame);
    }

    #start(address) {
      const inside = this.#frame.contentWindow;
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent('message', { data }));
      const script = inside.document.createElement('script');
      script.src = address;
      script.onload = () => {
        this.#ready = true;
        this.#waiting.splice(0).forEach((data) => this.postMessage(data));
      };
      inside.document.body.append(script);
    }

    postMessage(data) {
      if (this.#ready) this.#frame.contentWindow.dispatchEvent(new MessageEvent('message', { data }));
      else this.#waiting.push(data);
    }

    terminate() {
      this.#frame.remove();
    }
  };
}
