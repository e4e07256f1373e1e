/** What a browser keeps between visits; in frames of other sites it may keep nothing, and even asking throws. */

export interface Store {
  getItem(key: string): string | null;
  /** Without room, nothing is kept. */
  setItem(key: string, value: string): void;
  removeItem(key: string): void;
  /** Whether it outlives the page. */
  readonly lasting: boolean;
}

function inMemory(): Store {
  const kept = new Map<string, string>();
  return {
    getItem: (key) => kept.get(key) ?? null,
    setItem: (key, value) => void kept.set(key, value),
    removeItem: (key) => void kept.delete(key),
    lasting: false,
  };
}

/** The browser's storage if it may be used, else one that lives as long as the page. @param browser for tests */
export function openStorage(browser: () => Storage = () => localStorage): Store {
  try {
    const storage = browser(); // throws where storage is blocked
    const probe = 'enfilade-probe';
    storage.setItem(probe, '');
    storage.removeItem(probe);
    return {
      getItem: (key) => storage.getItem(key),
      setItem: (key, value) => {
        try {
          storage.setItem(key, value);
        } catch {
          // no room
        }
      },
      removeItem: (key) => storage.removeItem(key),
      lasting: true,
    };
  } catch {
    return inMemory();
  }
}

/** Of this page. */
export const storage: Store = openStorage();

/** What is said while the server cannot be reached. @param what "text", "walk" */
export const outOfReachText = (what: string): string => storage.lasting
  ? `The server is out of reach. We saved your ${what} here, in this browser; we try again.`
  : `The server is out of reach. We keep your ${what} on this page, so leave it open; we try again.`;
