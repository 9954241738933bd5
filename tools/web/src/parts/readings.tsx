// SPDX-License-Identifier: MIT
// Some figures below each other.

export interface Reading {
    label: string;
    text: string; // with its unit
    isBad?: boolean;
}

export function Readings({ caption, rows }: { caption: string; rows: Reading[] }) {
    return (
        <table class="readings">
            <caption>{caption}</caption>
            <tbody>
                {rows.map(({ label, text, isBad = false }) => (
                    <tr key={label} class={isBad ? "broken" : ""}>
                        <th scope="row">{label}</th>
                        <td>{text}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}
