import type { LodcModel } from './loader.js';

/**
 * `<lodc-view>`: shows a `.lodc` file or a `.lods` stream, which is turned by pointer, touch and
 * arrow keys. Importing `lodc/view` defines it. Attributes:
 *
 * - `src`: the address
 * - `alt`: what is shown, in words
 * - `pixels`: a level errs by at most so many pixels (1); below 0 all triangles are drawn
 * - `level`: the same level from everywhere, counted from the finest, 0
 * - `poster`: the address of an image until the first picture
 * - `up`: `z` for models that stand on z, `y` otherwise
 *
 * Taken out of the document it frees its memory.
 */
export class LodcView extends HTMLElement {
  /** The model that is shown. */
  readonly model: LodcModel | null;
  addEventListener<K extends keyof LodcViewEventMap>(
    type: K,
    listener: (this: LodcView, event: LodcViewEventMap[K]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void;
}

export interface LodcViewEventMap extends HTMLElementEventMap {
  /** The first picture is drawn. */
  load: Event;
  /** Everything has come. */
  complete: Event;
  error: ErrorEvent;
}

declare global {
  interface HTMLElementTagNameMap {
    'lodc-view': LodcView;
  }
}
