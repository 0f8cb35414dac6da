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
 * - `autoplay`: its animation runs over and over, unless the reader wants less motion
 * - `animation`: the name of that animation; the first one without it
 *
 * Each is a property, too. Taken out of the document it frees its memory. All elements of a page
 * share one WebGL context.
 */
export class LodcView extends HTMLElement {
  src: string;
  alt: string;
  poster: string;
  up: string;
  /** null: chosen by `pixels`. */
  get level(): number | null;
  set level(level: number | string | null | undefined);
  /** null: 1. */
  get pixels(): number | null;
  set pixels(pixels: number | string | null | undefined);
  autoplay: boolean;
  animation: string;
  /** The model that is shown. */
  readonly model: LodcModel | null;
  /** Whether no animation runs. */
  readonly paused: boolean;
  /** Plays the animation that `animation` names, or the first one, over and over. */
  play(): void;
  /** Stops the animation where it is. */
  pause(): void;
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

/** What `<lodc-view>` takes in JSX. */
export interface LodcViewAttributes {
  src?: string;
  alt?: string;
  poster?: string;
  up?: 'y' | 'z';
  level?: number | string | null;
  pixels?: number | string | null;
  autoplay?: boolean;
  animation?: string;
}

/** The same, with what every element has. */
export interface LodcViewProps extends LodcViewAttributes {
  id?: string;
  class?: string;
  className?: string;
  style?: any;
  key?: any;
  ref?: any;
  slot?: string;
  children?: any;
}

declare global {
  namespace JSX {
    interface IntrinsicElements {
      'lodc-view': LodcViewProps;
    }
  }
  interface HTMLElementTagNameMap {
    'lodc-view': LodcView;
  }
}
