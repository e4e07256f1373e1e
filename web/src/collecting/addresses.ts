/** Where a collection is. */

/** In the API. */
export const addressOf = (collection: string): string => `collections/${encodeURIComponent(collection)}`;

/** The page on which its work is reviewed. @param more state, worker, path or view */
export const reviewPage = (collection: string, more: Readonly<Record<string, string>> = {}): string =>
  `/review?${new URLSearchParams({ collection, ...more })}`;
