import 'lodc/view';
export const chair = <lodc-view src="chair.lods" alt="A chair" pixels="2" class="wide" />;
// @ts-expect-error: a level is a number
export const wrong = <lodc-view level={{}} />;
