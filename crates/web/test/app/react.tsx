import type {} from 'lodc/react';
import 'lodc/view';
export const chair = <lodc-view src="chair.lods" alt="A chair" level={2} autoplay style={{ width: 300 }}
  ref={(view) => { view?.model?.triangles.toFixed(); }} />;
// @ts-expect-error: there is no such axis
export const wrong = <lodc-view up="x" />;
