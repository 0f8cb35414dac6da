import type { DetailedHTMLProps, HTMLAttributes } from 'react';
import type { LodcView, LodcViewAttributes } from './view.js';

/**
 * `<lodc-view>` for React 19, whose JSX is no longer global: `import type {} from 'lodc/react';`
 * once in a program. There is nothing to run: `import 'lodc/view';` defines the element.
 */
declare module 'react' {
  namespace JSX {
    interface IntrinsicElements {
      'lodc-view': DetailedHTMLProps<HTMLAttributes<LodcView>, LodcView> & LodcViewAttributes;
    }
  }
}
