// SPDX-License-Identifier: MIT
// Of a request while it is served.
export interface Job {
    progress(share: number): void;
    // Lets messages in; throws Stopped when one of them ends this request.
    breathe(): Promise<void>;
}
